/* /polyrad: what every file of this program says about where it came from. */
#ifndef RAD_OUTPUT_STAMP_H
#define RAD_OUTPUT_STAMP_H

#include "output/hdf.h"
#include "scene/deck.h"

/**
 * Create /polyrad with its attributes: title, bands, version, git_revision, compiler, flags, blas,
 * blas_parallel, hdf5, machine, threads, started, deck (the text), command.
 *
 * @param[in] started  seconds since 1970-01-01 UTC, written as ISO 8601
 * @return the open group, for more attributes and children; to be closed with rad_hdf_group_close
 */
hid_t rad_stamp(struct rad_hdf *h, const struct rad_deck *deck, const char *command, int threads,
                double started);

/* Seconds since 1970-01-01 UTC, by the calendar's clock. */
double rad_stamp_now(void);

#endif
