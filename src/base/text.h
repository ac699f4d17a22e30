/* Texts: UTF-8, and how far two words are apart. */
#ifndef RAD_BASE_TEXT_H
#define RAD_BASE_TEXT_H

#include <stdbool.h>
#include <stddef.h>

/* Bytes of the UTF-8 character at p, 0 if p[0..n) does not start with one; its number in *code. */
int rad_utf8_decode(const char *p, size_t n, unsigned *code);

/* Question marks for control characters and what is not UTF-8: a message is one line of UTF-8,
 * whatever of the user's text it quotes or cuts. */
void rad_make_printable(char *text);

/* Texts, one a line; owned, or NULL without memory. */
char *rad_join_lines(int n, const char *const *text);

/* The name of a file up to its last dot, then tail, then ending, or, if that is NULL, its own.
 * Owned, or NULL without memory. */
char *rad_path_of(const char *file, const char *tail, const char *ending);

/**
 * Letters to insert, delete or replace to come from a to b; of each word the first 63 count.
 *
 * @param[in] forgiving  case is ignored, and neighbours swapped count once (optimal string
 *                       alignment)
 */
int rad_edit_distance(const char *a, const char *b, bool forgiving);

#endif
