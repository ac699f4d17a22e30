#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "output/hdf.h"

bool rad_hdf_has(hid_t at, const char *name) {
  return H5Lexists(at, name, H5P_DEFAULT) > 0 && H5Oexists_by_name(at, name, H5P_DEFAULT) > 0;
}

/* Open attribute of at least one text or number, or negative; *n values. */
static hid_t open_attribute(hid_t at, const char *name, bool text, hssize_t *n) {
  if (H5Aexists(at, name) <= 0)
    return H5I_INVALID_HID;
  const hid_t attribute = H5Aopen(at, name, H5P_DEFAULT);
  if (attribute < 0)
    return attribute;
  const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
  const H5T_class_t class = H5Tget_class(type);
  const bool fits = text ? class == H5T_STRING && H5Tis_variable_str(type) > 0
                         : class == H5T_FLOAT || class == H5T_INTEGER;
  *n = H5Sget_simple_extent_npoints(space);
  H5Sclose(space);
  H5Tclose(type);
  if (fits && *n >= 1)
    return attribute;
  H5Aclose(attribute);
  return H5I_INVALID_HID;
}

static char *join(char *const *part, hssize_t n) {
  size_t size = 1;
  for (hssize_t i = 0; i < n; i++)
    size += 2 + (part[i] ? strlen(part[i]) : 0);
  char *text = rad_alloc(size, 1);
  char *end = text;
  for (hssize_t i = 0; text && i < n; i++)
    end += sprintf(end, "%s%s", i ? ", " : "", part[i] ? part[i] : "");
  return text;
}

/* Copies, because texts that HDF5 allocated are freed together and by HDF5. */
static char **copy_texts(char *const *lent, int n) {
  char **text = rad_calloc((size_t)n, sizeof *text);
  for (int i = 0; text && i < n; i++) {
    text[i] = strdup(lent[i] ? lent[i] : "");
    if (!text[i]) {
      rad_hdf_texts_free(text, n);
      text = NULL;
    }
  }
  return text;
}

char **rad_hdf_get_texts(hid_t at, const char *name, int *n) {
  hssize_t count;
  const hid_t attribute = open_attribute(at, name, true, &count);
  if (attribute < 0)
    return NULL;
  const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
  char **text = NULL, **lent = count < 1 << 30 ? rad_calloc((size_t)count, sizeof *lent) : NULL;
  if (lent && H5Aread(attribute, type, lent) >= 0) {
    *n = (int)count;
    text = copy_texts(lent, *n);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, lent);
  }
  free(lent);
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attribute);
  return text;
}

char *rad_hdf_get_text(hid_t at, const char *name) {
  int n;
  char **part = rad_hdf_get_texts(at, name, &n);
  char *text = part ? join(part, n) : NULL;
  if (part)
    rad_hdf_texts_free(part, n);
  return text;
}

double rad_hdf_get_number(hid_t at, const char *name) {
  hssize_t n;
  const hid_t attribute = open_attribute(at, name, false, &n);
  if (attribute < 0)
    return NAN;
  double value = NAN;
  if (n != 1 || H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
    value = NAN;
  H5Aclose(attribute);
  return value;
}

static hid_t open_dataset(hid_t at, const char *name) {
  if (!rad_hdf_has(at, name))
    return H5I_INVALID_HID;
  const hid_t dataset = H5Oopen(at, name, H5P_DEFAULT);
  if (dataset >= 0 && H5Iget_type(dataset) != H5I_DATASET) {
    H5Oclose(dataset);
    return H5I_INVALID_HID;
  }
  return dataset;
}

bool rad_hdf_read_into(hid_t at, const char *name, enum rad_hdf_type type, size_t n, void *data) {
  const hid_t dataset = open_dataset(at, name);
  if (dataset < 0)
    return false;
  hid_t memory = H5I_INVALID_HID, file = H5I_INVALID_HID;
  rad_hdf_type_of(type, &memory, &file);
  const hid_t is = H5Dget_type(dataset), space = H5Dget_space(dataset);
  bool done = H5Tequal(is, file) > 0 && H5Sget_simple_extent_npoints(space) == (hssize_t)n;
  if (done && n > 0)
    done = H5Dread(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
  H5Sclose(space);
  H5Tclose(is);
  H5Dclose(dataset);
  return done;
}

double *rad_hdf_read_numbers(hid_t at, const char *name, hsize_t shape[RAD_HDF_MAX_RANK]) {
  const hid_t dataset = open_dataset(at, name);
  if (dataset < 0)
    return NULL;
  const hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
  const H5T_class_t class = H5Tget_class(type);
  const int rank = H5Sget_simple_extent_ndims(space);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  double *value = NULL;
  for (int k = 0; k < RAD_HDF_MAX_RANK; k++)
    shape[k] = 1;
  if ((class == H5T_FLOAT || class == H5T_INTEGER) && rank >= 0 && rank <= RAD_HDF_MAX_RANK &&
      n >= 0 && H5Sget_simple_extent_dims(space, shape, NULL) >= 0)
    value = rad_alloc((size_t)n, sizeof *value);
  if (value && n > 0 &&
      H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value) < 0) {
    free(value);
    value = NULL;
  }
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(dataset);
  return value;
}

char **rad_hdf_read_texts(hid_t at, const char *name, int *n) {
  const hid_t dataset = open_dataset(at, name);
  if (dataset < 0)
    return NULL;
  const hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  char **text = NULL, **lent = NULL;
  if (H5Tis_variable_str(type) > 0 && H5Sget_simple_extent_ndims(space) == 1 && count >= 0 &&
      count < 1 << 30)
    lent = rad_calloc((size_t)count, sizeof *lent);
  if (lent && (count == 0 || H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, lent) >= 0)) {
    *n = (int)count;
    text = copy_texts(lent, *n);
    if (count > 0)
      H5Dvlen_reclaim(type, space, H5P_DEFAULT, lent);
  }
  free(lent);
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(dataset);
  return text;
}

void rad_hdf_texts_free(char **text, int n) {
  for (int i = 0; text && i < n; i++)
    free(text[i]);
  free(text);
}
