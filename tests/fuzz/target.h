/* What the fuzz targets share. A target is libFuzzer's entry point over one reader; libFuzzer
 * drives it in builds with -Dfuzzer=true (tools/fuzz), replay.c in all others. */
#ifndef POLYRAD_FUZZ_TARGET_H
#define POLYRAD_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n);

/* The path of a file, in memory if that can be, that holds these bytes until the next call. */
const char *fuzz_file(const void *bytes, size_t n);

/* Ends the process, which both drivers report with the input. */
#define REQUIRE(condition) ((condition) ? (void)0 : fuzz_broken(#condition, __FILE__, __LINE__))
void fuzz_broken(const char *condition, const char *file, int line) __attribute__((noreturn));

/* What every reader promises: a code of the user's or the machine's, and one printable line. */
void fuzz_check_error(enum rad_code code, const struct rad_error *e);

#endif
