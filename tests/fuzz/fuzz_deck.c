/* The deck reader: a deck, then overrides, each behind a zero byte; what reads well is built. */
#include <omp.h>
#include <string.h>

#include "scene/scene.h"
#include "target.h"

enum { MOST_SET = 8, MOST_BYTES = 1 << 16, MOST_BUILT = 100 };

/* A mesh would be a file of this machine; many triangles only take time. */
static void build(const struct rad_deck *deck) {
  struct rad_scene scene;
  struct rad_notes notes = {0};
  struct rad_error e = {0};
  if (deck->mesh_file || deck->n_triangle > MOST_BUILT)
    return;
  enum rad_code code = rad_scene_build(deck, &scene, &notes, &e);
  fuzz_check_error(code, &e);
  REQUIRE(code || (scene.n_triangle > 0 && scene.size > 0));
  rad_scene_free(&scene);
  rad_notes_free(&notes);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n) {
  static char text[MOST_BYTES + 1];
  const char *set[MOST_SET];
  int n_set = 0;
  struct rad_deck deck;
  struct rad_error e = {0};
  if (n > MOST_BYTES)
    return 0;
  memcpy(text, bytes, n);
  text[n] = '\0';
  size_t n_deck = strlen(text);
  for (size_t i = n_deck; i < n && n_set < MOST_SET; i += 1 + strlen(text + i + 1))
    set[n_set++] = text + i + 1;
  omp_set_num_threads(1);
  enum rad_code code = rad_deck_read(fuzz_file(text, n_deck), n_set, set, &deck, &e);
  fuzz_check_error(code, &e);
  if (!code)
    build(&deck);
  rad_deck_free(&deck);
  return 0;
}
