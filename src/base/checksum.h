/* A number that tells whether bytes are as they were. */
#ifndef RAD_BASE_CHECKSUM_H
#define RAD_BASE_CHECKSUM_H

#include <stddef.h>
#include <stdint.h>

/**
 * Continue a checksum, which begins with any number, over n bytes.
 *
 * FNV-1a with words of 8 bytes in place of bytes, in eight lanes. Every step is one-to-one in the
 * word and in the sum so far: one word that changed always shows, and several do but for one time
 * in 2^64. Not meant against forgery. The sum of pieces is not the sum of the whole.
 */
uint64_t rad_checksum(uint64_t sum, const void *bytes, size_t n);

#endif
