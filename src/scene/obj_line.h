/* The words of a text file, statement by statement: for obj.c. */
#ifndef RAD_SCENE_OBJ_LINE_H
#define RAD_SCENE_OBJ_LINE_H

#include <stddef.h>

/* A place in a text that ends with a zero byte and holds no other. */
struct rad_scan {
  const char *at;
  int line; /* of the statement, from 1 */
  int next; /* of `at`; larger after a continued line */
};

struct rad_word {
  const char *text;
  size_t n;
};

/**
 * The next word of the statement. Blanks separate words; a backslash at the end of a line continues
 * it; a word that starts with # ends it.
 *
 * @return 0 at the end of the statement
 */
int rad_scan_word(struct rad_scan *s, struct rad_word *word);

/* The rest of the line, without blanks at its ends and without a comment. */
struct rad_word rad_scan_rest(struct rad_scan *s);

/* Pass over the rest of the statement. 0 at the end of the text. */
int rad_scan_next(struct rad_scan *s);

#endif
