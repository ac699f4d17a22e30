/* The OBJ reader; a file that reads well becomes a scene, every surface grey. */
#include <math.h>
#include <omp.h>
#include <string.h>

#include "scene/obj.h"
#include "scene/scene.h"
#include "target.h"

enum { MOST_BUILT = 100 };

static void check(const struct rad_obj *obj) {
  REQUIRE(obj->n_vertex >= 3 && obj->n_triangle > 0 && obj->n_part > 0);
  for (int v = 0; v < obj->n_vertex; v++)
    REQUIRE(isfinite(obj->vertex[v][0]) && isfinite(obj->vertex[v][1]) &&
            isfinite(obj->vertex[v][2]));
  for (int t = 0; t < obj->n_triangle; t++) {
    const struct rad_obj_triangle *f = &obj->triangle[t];
    for (int k = 0; k < 3; k++)
      REQUIRE(f->vertex[k] >= 0 && f->vertex[k] < obj->n_vertex &&
              f->vertex[k] != f->vertex[(k + 1) % 3]);
    REQUIRE(f->part >= 0 && f->part < obj->n_part && f->line > 0);
  }
  for (int p = 0; p < obj->n_part; p++)
    REQUIRE(obj->part_name[p]);
}

static void build(const struct rad_obj *obj, char *path) {
  static struct rad_deck_surface surface[MOST_BUILT];
  struct rad_deck deck = {
      .path = (char[]){"/fuzz.yml"}, .n_band = 1, .mesh_file = path, .mesh_scale = 1};
  if (obj->n_triangle > MOST_BUILT)
    return;
  for (int p = 0; p < obj->n_part; p++) {
    int same = 0;
    while (same < deck.n_surface && strcmp(surface[same].name, obj->part_name[p]))
      same++;
    if (same == deck.n_surface)
      surface[deck.n_surface++] = (struct rad_deck_surface){
          .name = obj->part_name[p], .optics = {.has_rho = true, .has_emission = true}};
  }
  deck.surface = surface;
  struct rad_scene scene;
  struct rad_notes notes = {0};
  struct rad_error e = {0};
  enum rad_code code = rad_scene_build(&deck, &scene, &notes, &e);
  fuzz_check_error(code, &e);
  REQUIRE(code || (scene.n_triangle == obj->n_triangle && scene.size > 0));
  rad_scene_free(&scene);
  rad_notes_free(&notes);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n) {
  struct rad_obj obj;
  struct rad_notes notes = {0};
  struct rad_error e = {0};
  char path[64];
  strcpy(path, fuzz_file(bytes, n));
  omp_set_num_threads(1);
  enum rad_code code = rad_obj_read(path, &obj, &notes, &e);
  fuzz_check_error(code, &e);
  if (!code) {
    check(&obj);
    build(&obj, path);
  }
  rad_notes_free(&notes);
  rad_obj_free(&obj);
  return 0;
}
