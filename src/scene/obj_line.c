#include "scene/obj_line.h"

#include <string.h>

static int is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/* Length of a backslash and the line end after it, or 0. */
static size_t continuation(const char *s) {
  if (s[0] != '\\')
    return 0;
  return s[1] == '\n' ? 2 : s[1] == '\r' && s[2] == '\n' ? 3 : 0;
}

static void skip_blanks(struct rad_scan *s) {
  for (;;) {
    size_t n = continuation(s->at);
    if (!n && !is_blank(*s->at))
      return;
    s->at += n ? n : 1;
    s->next += n > 0;
  }
}

int rad_scan_word(struct rad_scan *s, struct rad_word *word) {
  skip_blanks(s);
  word->text = s->at;
  if (*s->at == '#')
    return 0;
  while (*s->at && *s->at != '\n' && !is_blank(*s->at) && !continuation(s->at))
    s->at++;
  word->n = (size_t)(s->at - word->text);
  return word->n > 0;
}

struct rad_word rad_scan_rest(struct rad_scan *s) {
  while (is_blank(*s->at))
    s->at++;
  struct rad_word rest = {s->at, strcspn(s->at, "\n")};
  s->at += rest.n;
  for (size_t k = 0; k < rest.n; k++)
    if (rest.text[k] == '#' && (k == 0 || is_blank(rest.text[k - 1])))
      rest.n = k;
  while (rest.n > 0 && is_blank(rest.text[rest.n - 1]))
    rest.n--;
  return rest;
}

int rad_scan_next(struct rad_scan *s) {
  struct rad_word word;
  while (rad_scan_word(s, &word))
    ;
  s->at += strcspn(s->at, "\n"); /* a comment is not continued */
  if (!*s->at)
    return 0;
  s->at++;
  s->line = ++s->next;
  return 1;
}
