#include "base/text.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"

enum { MAX_WORD = 63 };

int rad_utf8_decode(const char *p, size_t n, unsigned *code) {
  const unsigned char *s = (const unsigned char *)p;
  if (n == 0)
    return 0;
  int length = s[0] < 0x80                   ? 1
               : s[0] >= 0xC2 && s[0] < 0xE0 ? 2
               : s[0] >= 0xE0 && s[0] < 0xF0 ? 3
               : s[0] >= 0xF0 && s[0] < 0xF5 ? 4
                                             : 0;
  if (length == 0 || (size_t)length > n)
    return 0;
  unsigned c = length == 1 ? s[0] : s[0] & (0x7Fu >> length);
  for (int i = 1; i < length; i++) {
    if ((s[i] & 0xC0) != 0x80)
      return 0;
    c = c << 6 | (s[i] & 0x3Fu);
  }
  static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
  *code = c;
  return c < least[length] || c > 0x10FFFF || (c >= 0xD800 && c <= 0xDFFF) ? 0 : length;
}

void rad_make_printable(char *text) {
  size_t n = strlen(text);
  for (size_t i = 0; i < n;) {
    unsigned code;
    int length = rad_utf8_decode(text + i, n - i, &code);
    if (length == 0 || code < 0x20 || (code >= 0x7F && code < 0xA0))
      for (int k = 0; k < (length ? length : 1); k++)
        text[i + (size_t)k] = '?';
    i += (size_t)(length ? length : 1);
  }
}

static int least(int a, int b) {
  return a < b ? a : b;
}

static int letter(char c, bool forgiving) {
  return forgiving ? tolower((unsigned char)c) : (unsigned char)c;
}

int rad_edit_distance(const char *a, const char *b, bool forgiving) {
  int n = (int)strnlen(b, MAX_WORD), row[3][MAX_WORD + 1];
  int *before = row[0], *above = row[1], *now = row[2];
  for (int j = 0; j <= n; j++)
    above[j] = before[j] = j;
  for (int i = 1, m = (int)strnlen(a, MAX_WORD); i <= m; i++) {
    now[0] = i;
    for (int j = 1; j <= n; j++) {
      int p = letter(a[i - 1], forgiving), q = letter(b[j - 1], forgiving);
      now[j] = least(above[j - 1] + (p != q), least(above[j], now[j - 1]) + 1);
      if (forgiving && i > 1 && j > 1 && p == letter(b[j - 2], true) && letter(a[i - 2], true) == q)
        now[j] = least(now[j], before[j - 2] + 1);
    }
    int *oldest = before;
    before = above;
    above = now;
    now = oldest;
  }
  return above[n];
}

char *rad_join_lines(int n, const char *const *text) {
  size_t size = 1;
  for (int i = 0; i < n; i++)
    size += strlen(text[i]) + 1;
  char *all = rad_calloc(size, 1), *end = all;
  for (int i = 0; i < n && all; i++)
    end += sprintf(end, "%s%s", i ? "\n" : "", text[i]);
  return all;
}

char *rad_path_of(const char *file, const char *tail, const char *ending) {
  const char *slash = strrchr(file, '/'), *name = slash ? slash + 1 : file;
  const char *dot = strrchr(name, '.');
  size_t n_stem = dot && dot > name ? (size_t)(dot - file) : strlen(file);
  ending = ending ? ending : file + n_stem;
  size_t size = n_stem + strlen(tail) + strlen(ending) + 1;
  char *path = rad_alloc(size, 1);
  if (path)
    snprintf(path, size, "%.*s%s%s", (int)n_stem, file, tail, ending);
  return path;
}
