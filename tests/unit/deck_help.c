#include "deck_help.h"

#include <check.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

char deck_path[64];

void write_deck(const char *text, size_t n) {
  snprintf(deck_path, sizeof deck_path, "/tmp/polyrad-deck-%ld.yml", (long)getpid());
  FILE *f = fopen(deck_path, "wb");
  ck_assert_ptr_nonnull(f);
  ck_assert_uint_eq(fwrite(text, 1, n, f), n);
  ck_assert_int_eq(fclose(f), 0);
}

enum rad_code read_text(const char *text, int n_set, const char *const *set, struct rad_deck *deck,
                        struct rad_error *e) {
  write_deck(text, strlen(text));
  *e = (struct rad_error){0};
  enum rad_code code = rad_deck_read(deck_path, n_set, set, deck, e);
  unlink(deck_path);
  ck_assert_int_eq(e->code, code);
  return code;
}

void read_good(const char *text, int n_set, const char *const *set, struct rad_deck *deck) {
  struct rad_error e;
  enum rad_code code = read_text(text, n_set, set, deck, &e);
  ck_assert_msg(code == RAD_OK, "refused: %s", e.text);
}

const char full_deck[FULL_DECK] =
    "title: Every key\n"
    "bands: [visible, infrared]\n"
    "scene:\n"
    "  triangles:\n"
    "    - name: floor\n"
    "      vertices: [[0, 0, 0], [1, 0, 0], [0, 1d0, -2.5e-1]]\n"
    "      normal: [0, 0, 2]\n"
    "      rho: 0.5\n"
    "      emission: [0.25, 4]\n"
    "      grading: [2, 1, 3]\n"
    "      elements: [1, 2, 3, 4, 5, 6]\n"
    "    - vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n"
    "      side: both\n"
    "      rho: [0, 1]\n"
    "      emission: {vertices: [1, [2, 3], 0]}\n"
    "      grading: 2\n"
    "      elements: 7\n"
    "    - name: floor\n"
    "      vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n"
    "      grading: [1, 2, 3, 4, 5, 8]\n"
    "  mesh: {file: room.obj, scale: 1D-3}\n"
    "  surfaces:\n"
    "    lamp: {rho: 0, emission: 12, side: front}\n"
    "    wall.1: {rho: [0.5, 0.75], side: back}\n"
    "accuracy: {tolerance: 1e-4}\n"
    "method:\n"
    "  mesh: graded\n"
    "  elements: 16\n"
    "  grading: 3.0\n"
    "  degree: 23\n"
    "  angle: duffy\n"
    "  constant_layers: 2\n"
    "  quadrature_tolerance: 1e-12\n"
    "  matrix: hierarchical\n"
    "  solver: neumann\n"
    "  solver_tolerance: 1e-16\n"
    "  bounces: 0\n"
    "  ratio: 0.5\n"
    "  nodes: gauss\n"
    "probes:\n"
    "  - {name: a, surface: floor, at: [0.25, 0.5, 0]}\n"
    "  - at: [1, 2, 3]\n"
    "output: {file: corner.vtkhdf, sampling: 64, fields: [irradiance]}\n"
    "study:\n"
    "  vary:\n"
    "    method.elements: [1, 2, 4]\n"
    "    scene.triangles.0.rho: [0.5, [0, 1]]\n"
    "    scene.surfaces.wall.1.rho: [0.25]\n"
    "    title: ['a, \"b\"', plain text]\n"
    "  reference: {degree: 9, elements: 1, mesh: uniform}\n"
    "  stability: true\n";
