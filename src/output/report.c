#include "output/report.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static void column_free(struct rad_report_column *c) {
  free(c->head);
  free(c->unit);
  rad_hdf_texts_free(c->text, c->n_text);
  free(c->number);
}

void rad_report_free(struct rad_report *r) {
  for (int k = 0; k < r->n_column; k++)
    column_free(&r->column[k]);
  free(r->column);
  *r = (struct rad_report){0};
}

/* Takes over what c owns, whether or not it fits. */
static void append(struct rad_report *r, hid_t group, const char *name, int n_row,
                   struct rad_report_column c) {
  const hid_t dataset = H5Dopen2(group, name, H5P_DEFAULT);
  c.head = strdup(name);
  c.unit = dataset >= 0 ? rad_hdf_get_text(dataset, "unit") : NULL;
  if (dataset >= 0)
    H5Dclose(dataset);
  const bool fits = c.head && (r->n_column == 0 || n_row == r->n_row);
  struct rad_report_column *grown =
      fits ? realloc(r->column, sizeof *grown * ((size_t)r->n_column + 1)) : NULL;
  if (!grown) {
    column_free(&c);
    return;
  }
  r->column = grown;
  r->column[r->n_column++] = c;
  r->n_row = n_row;
}

void rad_report_names(struct rad_report *r, hid_t group, const char *name) {
  struct rad_report_column c = {0};
  c.text = rad_hdf_read_texts(group, name, &c.n_text);
  if (c.text)
    append(r, group, name, c.n_text, c);
}

void rad_report_numbers(struct rad_report *r, hid_t group, const char *name) {
  hsize_t shape[RAD_HDF_MAX_RANK];
  struct rad_report_column c = {0};
  c.number = rad_hdf_read_numbers(group, name, shape);
  if (!c.number)
    return;
  if (shape[0] > INT_MAX || shape[1] > INT_MAX || shape[2] != 1) {
    column_free(&c);
    return;
  }
  c.width = (int)shape[1];
  append(r, group, name, (int)shape[0], c);
}

void rad_report_group(struct rad_report *r, hid_t group) {
  H5G_info_t is;
  if (H5Gget_info(group, &is) < 0)
    return;
  for (hsize_t k = 0; k < is.nlinks; k++) {
    char name[256];
    if (H5Lget_name_by_idx(group, ".", H5_INDEX_CRT_ORDER, H5_ITER_INC, k, name, sizeof name,
                           H5P_DEFAULT) < 0 &&
        H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, k, name, sizeof name,
                           H5P_DEFAULT) < 0)
      continue;
    rad_report_names(r, group, name); /* at most one of the two finds its type */
    rad_report_numbers(r, group, name);
  }
}

/* One cell of the text: texts as they are, numbers joined by blanks. */
static void write_cell(const struct rad_report_column *c, int row, size_t size, char text[size]) {
  text[0] = '\0';
  if (c->text) {
    snprintf(text, size, "%s", c->text[row]);
    return;
  }
  for (int k = 0; k < c->width; k++) {
    const size_t used = strlen(text);
    const double x = c->number[(size_t)row * (size_t)c->width + (size_t)k];
    if (isnan(x))
      snprintf(text + used, size - used, "%s-", k ? " " : "");
    else
      snprintf(text + used, size - used, "%s%.6g", k ? " " : "", x);
  }
}

/* Row -2 is the head, -1 the unit. */
static void cell(const struct rad_report_column *c, int row, size_t size, char text[size]) {
  if (row == -2)
    snprintf(text, size, "%s", c->head);
  else if (row == -1)
    snprintf(text, size, "[%s]", c->text || !c->unit ? "" : c->unit);
  else
    write_cell(c, row, size, text);
  if (row == -1 && !strcmp(text, "[]"))
    text[0] = '\0';
}

/* Places on the screen: bytes of UTF-8 that begin a character. */
static int length(const char *text) {
  int n = 0;
  for (; *text; text++)
    n += (*text & 0xC0) != 0x80;
  return n;
}

static void print_cell(const struct rad_report_column *c, int row, int width, FILE *out) {
  char text[400];
  cell(c, row, sizeof text, text);
  const int gap = width - length(text);
  fprintf(out, "  %*s%s%*s", c->text ? 0 : gap, "", text, c->text ? gap : 0, "");
}

void rad_report_print(const struct rad_report *r, int max_row, FILE *out) {
  char text[400];
  const int n = r->n_row < max_row ? r->n_row : max_row;
  int *width = rad_calloc((size_t)r->n_column, sizeof *width);
  if (!width)
    return;
  for (int k = 0; k < r->n_column; k++)
    for (int row = -2; row < n; row++) {
      cell(&r->column[k], row, sizeof text, text);
      width[k] = length(text) > width[k] ? length(text) : width[k];
    }
  for (int row = -2; row < n; row++) {
    for (int k = 0; k < r->n_column; k++)
      print_cell(&r->column[k], row, width[k], out);
    fputc('\n', out);
  }
  if (n < r->n_row)
    fprintf(out, "  ... and %d more\n", r->n_row - n);
  free(width);
}
