#include "output/hdf.h"
#include "output/result.h"
#include "output/stamp.h"

static void write_columns(struct rad_hdf *h, hid_t group, const struct rad_table *table) {
  for (int k = 0; k < table->n_column; k++) {
    const struct rad_column *const c = &table->column[k];
    const hsize_t n = (hsize_t)table->n_row;
    if (c->number)
      rad_hdf_array(h, group,
                    &(struct rad_hdf_array){
                        c->name, c->unit, c->description, RAD_HDF_REAL, 1, {n}, c->number});
    else
      rad_hdf_texts(h, group, c->name, n, c->text, c->description);
  }
}

enum rad_code rad_table_write(const char *path, const struct rad_table *table,
                              const struct rad_deck *deck, const char *command, int threads,
                              struct rad_error *e) {
  struct rad_hdf h;
  rad_hdf_begin(&h);
  const hid_t root = rad_stamp(&h, deck, command, threads, rad_stamp_now());
  const hid_t group = rad_hdf_group(&h, root, "study");
  write_columns(&h, group, table);
  rad_hdf_group_close(&h, group);
  rad_hdf_group_close(&h, root);
  rad_hdf_link(&h, "/polyrad/study", "study");
  return rad_hdf_end(&h, path, e);
}
