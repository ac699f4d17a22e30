/* Columns read from a file, printed as aligned text. */
#ifndef RAD_OUTPUT_REPORT_H
#define RAD_OUTPUT_REPORT_H

#include <stdio.h>

#include "output/hdf.h"

struct rad_report_column {
  char *head;  /* owned */
  char *unit;  /* owned, or NULL */
  char **text; /* owned [n_text], or NULL */
  int n_text;
  double *number; /* owned [n_row, width], or NULL */
  int width;      /* numbers a row: bands, or coordinates */
};

struct rad_report {
  int n_row; /* that of the first column; others of another length are left out */
  int n_column;
  struct rad_report_column *column; /* owned [n_column] */
};

/* Append the dataset of that name: texts, or numbers [n] or [n, width]. Absent or odd ones are left
 * out. */
void rad_report_names(struct rad_report *r, hid_t group, const char *name);
void rad_report_numbers(struct rad_report *r, hid_t group, const char *name);

/* Append all datasets of a group, in the order of their making. */
void rad_report_group(struct rad_report *r, hid_t group);

/* Heads, units, and the first max_row rows. */
void rad_report_print(const struct rad_report *r, int max_row, FILE *out);

void rad_report_free(struct rad_report *r); /* safe twice */

#endif
