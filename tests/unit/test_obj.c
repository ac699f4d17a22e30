/* OBJ files: what is read, how polygons are cut, and for each mistake its line and message. */
#include <check.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/number.h"
#include "base/vec.h"
#include "deck_help.h"
#include "scene/obj.h"
#include "scene_help.h"
#include "suite.h"

static char obj_path[64];

static void write_obj(const char *text, size_t n) {
  snprintf(obj_path, sizeof obj_path, "/tmp/polyrad-%ld.room.obj", (long)getpid());
  FILE *f = fopen(obj_path, "wb");
  ck_assert_ptr_nonnull(f);
  ck_assert_uint_eq(fwrite(text, 1, n, f), n);
  ck_assert_int_eq(fclose(f), 0);
}

static enum rad_code read_obj(const char *text, size_t n, struct rad_obj *obj,
                              struct rad_notes *notes, struct rad_error *e) {
  write_obj(text, n);
  *notes = (struct rad_notes){0};
  *e = (struct rad_error){0};
  enum rad_code code = rad_obj_read(obj_path, obj, notes, e);
  unlink(obj_path);
  ck_assert_int_eq(e->code, code);
  return code;
}

/* Read a good file without warnings. */
static struct rad_obj good(const char *text) {
  struct rad_obj obj;
  struct rad_notes notes;
  struct rad_error e;
  enum rad_code code = read_obj(text, strlen(text), &obj, &notes, &e);
  ck_assert_msg(code == RAD_OK, "refused: %s", e.text);
  ck_assert_msg(notes.n == 0, "%s", notes.n ? notes.text[0] : "");
  return obj;
}

static double area(const struct rad_obj *obj, int t, double normal[3]) {
  double u[3], v[3];
  const int *k = obj->triangle[t].vertex;
  rad_sub(obj->vertex[k[1]], obj->vertex[k[0]], u);
  rad_sub(obj->vertex[k[2]], obj->vertex[k[0]], v);
  rad_cross(u, v, normal);
  return rad_norm(normal) / 2;
}

/* --- good files --- */

#define V4 "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

START_TEST(reads_all_forms) {
  static const char *const text[] = {
      V4 "f 1 2 3\nf 1 3 4\n",
      "\xEF\xBB\xBF# first\r\nv 0 0 0\r\nv 1. 0 0 1.0\r\nv +1 1d0 .0e5\r\nv 0 1E0 0 0.5 0.5 "
      "1\r\n\r\n"
      "f 1 2 3\r\nf 1 3 4\r\n",
      V4
      "vt 0 0\nvn 0 0 1\nmtllib a.mtl b.mtl\ns off\nl 1 2\np 1\nf 1/1 2/2 3/1 # end\n"
      "f 1//1 3//-1 4//7\n",
      "\t v\t0 0 \\\n0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2/1/1 3/1/1\nf -4 -2 \\\r\n -1",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf 1 -2/1 -1//2\n#",
      "v -0 0 0 1\nv 1 0 0 1 1 1 1\nv 1 1 0\nv 0 1 0\nf 1 2 3\nvp 1 2 3\nlod 3\nf 1 3 4\n",
  };
  for (int k = 0; k < COUNT(text); k++) {
    struct rad_obj obj = good(text[k]);
    static const int expected[2][3] = {{0, 1, 2}, {0, 2, 3}};
    static const double vertex[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    ck_assert_int_eq(obj.n_vertex, 4);
    ck_assert_int_eq(obj.n_triangle, 2);
    for (int t = 0; t < 2; t++)
      ck_assert_mem_eq(obj.triangle[t].vertex, expected[t], sizeof expected[t]);
    for (int m = 0; m < 12; m++)
      ck_assert(obj.vertex[m / 3][m % 3] == vertex[m / 3][m % 3]);
    ck_assert_int_eq(obj.n_part, 1);
    rad_obj_free(&obj);
    rad_obj_free(&obj);
  }
}
END_TEST

START_TEST(knows_the_lines_of_faces) {
  struct rad_obj obj =
      good("v 0 0 \\\n 0\nv 1 0 0 \\\r\n\nv 1 1 0\nv 0 1 0\n\n# c \\\nf 1 \\\n2 3\nf 1 3 4\n");
  ck_assert_int_eq(obj.triangle[0].line, 9);
  ck_assert_int_eq(obj.triangle[1].line, 11);
  rad_obj_free(&obj);
}
END_TEST

#define F "f 1 2 3\n"

/* Names of the runs of faces, joined by |; @ is the file's own. */
START_TEST(names_surfaces_by_one_rule) {
  static const struct {
    const char *text, *names;
  } cases[] = {
      {F, "@"},
      {"o box\n" F, "box"},
      {"o box\ng wall\n" F, "wall"},
      {"g wall\n" F "usemtl red\n", "@"},
      {F "usemtl red\n" F "g a\n" F "o b\nusemtl  blue sky # dark\n" F, "@|red|red|blue sky"},
      {"g left wall\r\n" F "g\n" F "g left wall\n" F, "left wall|@|left wall"},
      {"g a\n" F "g a\n" F "g b\ng a\n" F, "a"},
      {"o a#1\n" F "o b #2\n" F "o\n" F, "a#1|b|@"},
      {"usemtl \xC3\xBCml\n" F, "\xC3\xBCml"},
  };
  char own[64];
  for (int k = 0; k < COUNT(cases); k++) {
    char text[300], names[200] = "";
    snprintf(text, sizeof text, "v 0 0 0\nv 1 0 0\nv 0 1 0\n%s", cases[k].text);
    struct rad_obj obj = good(text);
    snprintf(own, sizeof own, "polyrad-%ld.room", (long)getpid());
    for (int p = 0; p < obj.n_part; p++) {
      strcat(names, p ? "|" : "");
      strcat(names, strcmp(obj.part_name[p], own) ? obj.part_name[p] : "@");
    }
    ck_assert_str_eq(names, cases[k].names);
    for (int t = 0; t < obj.n_triangle; t++)
      ck_assert(obj.triangle[t].part >= 0 && obj.triangle[t].part < obj.n_part);
    rad_obj_free(&obj);
  }
}
END_TEST

/* Corners of a polygon in x, y, turned and moved in space, as one face. */
static void write_polygon(char *text, int n, const double (*corner)[2], int first, int back,
                          const struct motion *motion) {
  for (int k = 0; k < n; k++) {
    double x[3], y[3] = {corner[k][0], corner[k][1], 0};
    move(motion, y, x);
    text += sprintf(text, "v %.17g %.17g %.17g\n", x[0], x[1], x[2]);
  }
  text += sprintf(text, "f");
  for (int k = 0; k < n; k++)
    text += sprintf(text, " %d", ((back ? n - k : k) + first) % n + 1);
  sprintf(text, "\n");
}

static double shoelace(int n, const double (*p)[2]) {
  double sum = 0;
  for (int k = 0; k < n; k++)
    sum += p[k][0] * p[(k + 1) % n][1] - p[(k + 1) % n][0] * p[k][1];
  return sum / 2;
}

/* The triangles of a polygon: n - 2 of them, all turned its way, of its area together, so that none
 * overlap. */
static void check_cut(int n, const double (*corner)[2]) {
  char *text = malloc((size_t)n * 100 + 100);
  ck_assert_ptr_nonnull(text);
  struct motion motion = random_motion(2);
  const double up[3] = {motion.axis[0][2], motion.axis[1][2], motion.axis[2][2]};
  double expected = shoelace(n, corner) * motion.scale * motion.scale;
  for (int k = 0; k < 6; k++) {
    write_polygon(text, n, corner, (k * 7) % n, k % 2, &motion);
    struct rad_obj obj = good(text);
    ck_assert_int_eq(obj.n_triangle, n - 2);
    double sum = 0;
    for (int t = 0; t < n - 2; t++) {
      double normal[3], one = area(&obj, t, normal);
      ck_assert_msg(rad_dot(normal, up) * (k % 2 ? -1 : 1) > 0, "turned, seed %llu", seed());
      sum += one;
    }
    /* coordinates of up to 10 extents, each rounded to 2^-53, in n areas */
    ck_assert_double_eq_tol(sum, expected, n * 1e-13 * expected);
    rad_obj_free(&obj);
  }
  free(text);
}

START_TEST(cuts_concave_polygons) {
  static const double arrow[4][2] = {{0, 0}, {2, 1}, {0, 2}, {0.7, 1}};
  static const double comb[12][2] = {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1},
                                     {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  static const double straight[8][2] = {{0, 0}, {1, 0},   {2, 0}, {2, 1},
                                        {1, 1}, {0.5, 1}, {0, 1}, {0, 0.5}};
  static const double split_side[4][2] = {{0, 0}, {1, 0}, {2, 0}, {0, 2}};
  start_random();
  for (int k = 0; k < 20; k++) {
    check_cut(4, arrow);
    check_cut(4, split_side);
    check_cut(12, comb);
    check_cut(8, straight);
    check_cut(6, ELL);
  }
}
END_TEST

/* Stars with random radii, and a spiral corridor, whose ears are few. */
START_TEST(cuts_random_polygons) {
  enum { N_SPIRAL = 400 };
  start_random();
  double corner[N_SPIRAL][2];
  for (int k = 0; k < 100; k++) {
    int n = 3 + k % 40;
    for (int m = 0; m < n; m++) {
      double angle = 6.283185307179586 * (m + uniform(0, 0.5)) / n, radius = uniform(0.2, 1);
      corner[m][0] = radius * cos(angle);
      corner[m][1] = radius * sin(angle);
    }
    check_cut(n, corner);
  }
  for (int m = 0; m < N_SPIRAL; m++) { /* out on the inner side, back on the outer */
    int step = m < N_SPIRAL / 2 ? N_SPIRAL / 2 - 1 - m : m - N_SPIRAL / 2;
    double radius = 1 + 0.05 * step + (m < N_SPIRAL / 2 ? 0 : 0.4), angle = 0.2 * step;
    corner[m][0] = radius * cos(angle);
    corner[m][1] = radius * sin(angle);
  }
  check_cut(N_SPIRAL, corner);
}
END_TEST

/* A kite has one good split; a square has two equal ones, and takes the lower vertex from either
 * side, so that a slit's faces match. */
START_TEST(splits_quadrilaterals_well) {
  static const char *const faces[] = {"f 1 2 3 4\n", "f 3 2 1 4\n", "f 2 3 4 1\n", "f 4 3 2 1\n"};
  for (int k = 0; k < COUNT(faces); k++)
    for (int kite = 0; kite < 2; kite++) {
      char text[200];
      snprintf(text, sizeof text, "v 0 0 0\nv 1 %s 0\nv %s 0\nv %s 1 0\n%s", kite ? "-1" : "0",
               kite ? "9 0" : "1 1", kite ? "1" : "0", faces[k]);
      struct rad_obj obj = good(text);
      for (int t = 0; t < 2; t++) {
        int has_first = 0;
        for (int m = 0; m < 3; m++)
          has_first += obj.triangle[t].vertex[m] == (kite ? 1 : 0) ||
                       obj.triangle[t].vertex[m] == (kite ? 3 : 2);
        ck_assert_int_eq(has_first, 2);
      }
      rad_obj_free(&obj);
    }
}
END_TEST

START_TEST(warns_of_bent_faces) {
  char text[6000] = "", *s = text;
  for (int k = 0; k < 30; k++) { /* bend 1 +- 1 % times a quarter of 4e-6 * sqrt(2) ... */
    double lift = k == 3 ? 3.9e-6 * sqrt(2.0) : 4.1e-6 * sqrt(2.0) * 2;
    s += sprintf(s, "v %d 0 0\nv %d 0 0\nv %d 1 %.9g\nv %d 1 0\nf -4 -3 -2 -1\n", 2 * k, 2 * k + 1,
                 2 * k + 1, lift, 2 * k);
  }
  struct rad_obj obj;
  struct rad_notes notes;
  struct rad_error e;
  ck_assert_int_eq(read_obj(text, strlen(text), &obj, &notes, &e), RAD_OK);
  ck_assert_int_eq(obj.n_triangle, 60);
  ck_assert_int_eq(notes.n, RAD_MAX_BENT_NOTES + 1);
  char expected[300];
  snprintf(
      expected, sizeof expected,
      "%s:5: warning: the face is not plane (2.1e-06 of its diameter); its triangles are used, "
      "divide it to choose them",
      obj_path);
  ck_assert_msg(strstr(notes.text[0], ":5: warning: the face is not plane ("), "%s", notes.text[0]);
  ck_assert_ptr_nonnull(strstr(notes.text[3], ":25: warning"));
  snprintf(expected, sizeof expected, "%s: warning: and 9 more faces that are not plane", obj_path);
  ck_assert_str_eq(notes.text[RAD_MAX_BENT_NOTES], expected);
  rad_notes_free(&notes);
  rad_obj_free(&obj);
}
END_TEST

/* Half a million faces, and one face of ten thousand corners. */
START_TEST(reads_large_files) {
  enum { N = 500, N_CORNER = 10000 };
  char *text = malloc((N + 1) * (N + 1) * 24 + N * N * 32 + 100), *s = text;
  for (int k = 0; k < (N + 1) * (N + 1); k++)
    s += sprintf(s, "v %d %d 0\n", k % (N + 1), k / (N + 1));
  for (int k = 0; k < N * N; k++) {
    int first = k / N * (N + 1) + k % N + 1;
    s += sprintf(s, "f %d %d %d %d\n", first, first + 1, first + N + 2, first + N + 1);
  }
  struct rad_obj obj = good(text);
  ck_assert_int_eq(obj.n_triangle, 2 * N * N);
  ck_assert_int_eq(obj.triangle[2 * N * N - 1].line, (N + 1) * (N + 1) + N * N);
  double sum = 0, normal[3];
  for (int t = 0; t < obj.n_triangle; t++)
    sum += area(&obj, t, normal);
  ck_assert_double_eq_tol(sum, N * N, 1e-6);
  rad_obj_free(&obj);
  s = text;
  for (int k = 0; k < N_CORNER; k++)
    s += sprintf(s, "v %.17g %.17g 0\n", cos(k * 6.283185307179586 / N_CORNER),
                 sin(k * 6.283185307179586 / N_CORNER));
  s += sprintf(s, "f");
  for (int k = 0; k < N_CORNER; k++)
    s += sprintf(s, " %d", k + 1);
  obj = good(text);
  ck_assert_int_eq(obj.n_triangle, N_CORNER - 2);
  rad_obj_free(&obj);
  free(text);
}
END_TEST

START_TEST(reads_one_long_line) {
  enum { N = 300000 };
  char *text = malloc(N + 200);
  strcpy(text, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 ");
  size_t n = strlen(text);
  memset(text + n, ' ', N);
  strcpy(text + n + N, "3\n");
  struct rad_obj obj = good(text);
  ck_assert_int_eq(obj.n_triangle, 1);
  rad_obj_free(&obj);
  free(text);
}
END_TEST

/* --- numbers --- */

/* The same doubles as strtod, of random numbers in many forms. */
START_TEST(numbers_are_the_nearest_doubles) {
  start_random();
  for (int k = 0; k < 20000; k++) {
    char text[64];
    int precision = (int)uniform(0, 22);
    double x = uniform(-1, 1) * pow(10, uniform(-30, 30) * (k % 3)), value = NAN;
    snprintf(text, sizeof text, k % 2 ? "%.*g" : "%+.*e", precision, x);
    ck_assert(rad_number_parse(text, strlen(text), &value));
    ck_assert_msg(value == strtod(text, NULL), "%s: %.17g", text, value);
  }
  static const char *const no[] = {"",    "-",     ".",  "e5", "1e",  "1e+", "0x10",  "inf", "nan",
                                   "1,5", "1e999", "1 ", " 1", "1_0", "--1", "1.2.3", "1f",  "+-1"};
  double value = 7;
  for (int k = 0; k < COUNT(no); k++)
    ck_assert_msg(!rad_number_parse(no[k], strlen(no[k]), &value) && value == 7, "%s", no[k]);
  ck_assert(rad_number_parse("0.00000000000000000000000000125x", 31, &value) && value == 1.25e-27);
  ck_assert(rad_number_parse("-1D-3", 5, &value) && value == -1e-3);
  ck_assert(rad_number_parse("1e-999999999999999999999", 24, &value) && value == 0);
}
END_TEST

START_TEST(numbers_in_another_locale) {
  const char *names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "C"};
  int k = 0;
  while (!setlocale(LC_ALL, names[k]))
    k++;
  double value;
  ck_assert(rad_number_parse("1.5", 3, &value) && value == 1.5);
  ck_assert(rad_number_parse("0.12345678901234567890123", 25, &value) &&
            value == 0.12345678901234567890123);
  setlocale(LC_ALL, "C");
}
END_TEST

/* --- bad files --- */

#define V3 "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
#define CORNER "write vertex numbers as 1, 1/2, 1//3 or 1/2/3"
#define COORDINATES "give x y z as decimal numbers after 'v'"

static const struct {
  const char *text;
  int line; /* 0: the file as a whole */
  const char *message;
} bad[] = {
    {"", 0, "the file is empty; export the scene again"},
    {" \n\t\r\n", 0, "the file is empty; export the scene again"},
    {"# nothing\n", 0, "there are no faces in the file; export polygons ('f' lines)"},
    {V3, 0, "there are no faces in the file; export polygons ('f' lines)"},
    {V3 "l 1 2 3\n", 0, "there are no faces in the file; export polygons ('f' lines)"},
    {"v 0 0 x\n", 1, "'x' is no finite number; " COORDINATES},
    {"v 0 0 0x10\n", 1, "'0x10' is no finite number; " COORDINATES},
    {"v 0 0 nan\n", 1, "'nan' is no finite number; " COORDINATES},
    {"v 0 0 inf\n", 1, "'inf' is no finite number; " COORDINATES},
    {"v 0 0 1e400\n", 1, "'1e400' is no finite number; " COORDINATES},
    {"v 0 0 1,5\n", 1, "'1,5' is no finite number; " COORDINATES},
    {"v 0 0 1e\n", 1, "'1e' is no finite number; " COORDINATES},
    {"\n\nv 0 \\\n 0 \\\n z\n", 3, "'z' is no finite number; " COORDINATES},
    {"v 0 0 \xFF\x01\n", 1, "'?\?' is no finite number; " COORDINATES},
    {"v 0 0 1234567890123456789012345678901234567890x567890\n", 1,
     "'1234567890123456789012345678901234567890' is no finite number; " COORDINATES},
    {"v\n", 1, "a vertex with 0 numbers; give x y z after 'v'"},
    {"v 0\n", 1, "a vertex with 1 number; give x y z after 'v'"},
    {"v 0 0\n", 1, "a vertex with 2 numbers; give x y z after 'v'"},
    {"v 0 0 0 1 1\n", 1, "a vertex with 5 numbers; give x y z after 'v'"},
    {"v 0 0 0 1 1 1 1 1\n", 1, "a vertex with more than 7 numbers; give x y z after 'v'"},
    {"v 0 0 0 0.5\n", 1,
     "a vertex of weight 0.5, but only polygons are read; leave the weight out"},
    {V3 "f\n", 4, "a face with 0 corners; give at least three"},
    {V3 "f 1\n", 4, "a face with 1 corner; give at least three"},
    {V3 "f 1 2 # 3\n", 4, "a face with 2 corners; give at least three"},
    {V3 "f 1 2 a\n", 4, "'a' is no corner of a face; " CORNER},
    {V3 "f 1 2 3.0\n", 4, "'3.0' is no corner of a face; " CORNER},
    {V3 "f 1 2 3/\n", 4, "'3/' is no corner of a face; " CORNER},
    {V3 "f 1 2 3//\n", 4, "'3//' is no corner of a face; " CORNER},
    {V3 "f 1 2 3/1/\n", 4, "'3/1/' is no corner of a face; " CORNER},
    {V3 "f 1 2 3/1/1/1\n", 4, "'3/1/1/1' is no corner of a face; " CORNER},
    {V3 "f 1 2 3/a\n", 4, "'3/a' is no corner of a face; " CORNER},
    {V3 "f 1 2 /3\n", 4, "'/3' is no corner of a face; " CORNER},
    {V3 "f 1 2 +3\n", 4, "'+3' is no corner of a face; " CORNER},
    {V3 "f 1 2 -\n", 4, "'-' is no corner of a face; " CORNER},
    {V3 "f 0 1 2\n", 4, "there is no vertex 0; count from 1, or from -1 for the last one above"},
    {V3 "f 1 2 4\n", 4, "there is no vertex 4, only 3 above this line; correct the number"},
    {V3 "f 1 2 -4/1\n", 4, "there is no vertex -4, only 3 above this line; correct the number"},
    {"f 1 2 3\n" V3, 1, "there is no vertex 1, only 0 above this line; correct the number"},
    {V3 "f 1 2 99999999999999999999\n", 4,
     "there is no vertex 99999999999999999999, only 3 above this line; correct the number"},
    {V3 "f 1 2 1\n", 4, "corners 1 and 3 of the face are both vertex 1; remove one of them"},
    {V3 "f 1 2 3 -2\n", 4, "corners 2 and 4 of the face are both vertex 2; remove one of them"},
    {"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", 4,
     "a face without area, its corners lie on a line; move one or delete the face"},
    {"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", 4,
     "a face without area, its corners lie on a line; move one or delete the face"},
    {V4 "f 1 2 4 3\n", 5,
     "a face without area, its corners lie on a line; move one or delete the face"},
    {"v 0 0 0\nv 3 0 0\nv 1 2 0\nv 1 -1 0\nf 1 2 3 4\n", 5,
     "the outline of the face crosses or touches itself; divide the face"},
    {V3 "v 3 2 0\nv 3 0 0\nf 1 4 2 5 3\n", 6,
     "the outline of the face crosses or touches itself; divide the face"},
    {V3 "usemtl\nf 1 2 3\n", 4, "'usemtl' without a name; write usemtl NAME"},
    {"g a\xE9\n" V3, 1, "byte 0xE9 in the name after 'g'; give names in UTF-8, on one line"},
    {V3 "usemtl a\tb\n", 4,
     "byte 0x09 in the name after 'usemtl'; give names in UTF-8, on one line"},
    {V3 "face 1 2 3\n", 4,
     "unknown statement 'face'; this is to be a Wavefront OBJ file: v, f, g, o, usemtl"},
    {"solid cube\n", 1,
     "unknown statement 'solid'; this is to be a Wavefront OBJ file: v, f, g, o, usemtl"},
    {"\x7F"
     "ELF\x02\x01\n",
     1, "unknown statement '?ELF?\?'; this is to be a Wavefront OBJ file: v, f, g, o, usemtl"},
    {"F 1 2 3\n", 1,
     "unknown statement 'F'; this is to be a Wavefront OBJ file: v, f, g, o, usemtl"},
    {V3 "cstype bezier\n", 4, "'cstype' belongs to a free-form surface; export polygons"},
    {V3 "curv2 1 2\n", 4, "'curv2' belongs to a free-form surface; export polygons"},
};

static void refused(const char *text, size_t n, int line, const char *message) {
  struct rad_obj obj;
  struct rad_notes notes;
  struct rad_error e;
  char expected[600], place[16] = "";
  ck_assert_int_eq(read_obj(text, n, &obj, &notes, &e), RAD_EINPUT);
  rad_obj_free(&obj);
  rad_notes_free(&notes);
  if (line)
    snprintf(place, sizeof place, ":%d", line);
  snprintf(expected, sizeof expected, "%s%s: error: %s", obj_path, place, message);
  ck_assert_str_eq(e.text, expected);
}

START_TEST(refuses) {
  refused(bad[_i].text, strlen(bad[_i].text), bad[_i].line, bad[_i].message);
}
END_TEST

START_TEST(refuses_a_zero_byte) {
  static const char text[] = V3 "f 1 2 3\n\0 and more";
  refused(text, sizeof text - 1, 5,
          "a zero byte, so this is no text; export the scene as a Wavefront OBJ file");
}
END_TEST

START_TEST(refuses_a_face_of_very_many_corners) {
  enum { N = 10001 };
  char *text = malloc(N * 50), *s = text;
  for (int k = 0; k < N; k++)
    s += sprintf(s, "v %d %d 0\n", k, k * k % 1000);
  s += sprintf(s, "f");
  for (int k = 0; k < N; k++)
    s += sprintf(s, " %d", k + 1);
  refused(text, strlen(text), N + 1, "a face of more than 10000 corners; divide it");
  free(text);
}
END_TEST

START_TEST(unreadable_files) {
  static const struct {
    const char *path, *message;
  } no[] = {
      {"/nonexistent/a.obj",
       "/nonexistent/a.obj: error: cannot open the mesh (scene.mesh.file): No such file or "
       "directory; check its name and permissions"},
      {"/tmp",
       "/tmp: error: cannot read the mesh (scene.mesh.file): Is a directory; give a text "
       "file"},
  };
  for (int k = 0; k < COUNT(no); k++) {
    struct rad_obj obj;
    struct rad_notes notes = {0};
    struct rad_error e;
    ck_assert_int_eq(rad_obj_read(no[k].path, &obj, &notes, &e), RAD_ESYSTEM);
    ck_assert_str_eq(e.text, no[k].message);
    rad_obj_free(&obj);
  }
  struct rad_obj obj; /* without an end */
  struct rad_notes notes = {0};
  struct rad_error e;
  ck_assert_int_eq(rad_obj_read("/dev/zero", &obj, &notes, &e), RAD_EINPUT);
  ck_assert_str_eq(e.text,
                   "/dev/zero:1: error: a zero byte, so this is no text; export the scene as "
                   "a Wavefront OBJ file");
  rad_obj_free(&obj);
}
END_TEST

/* Cuts and flips bytes: any answer is fine, but never a crash or a leak. */
START_TEST(damaged_files) {
  static const char whole[] = V4
      "v 0.5 0.5 1\ng a b\nusemtl m # c\nf 1/1 2/2 3/3 4/4\n"
      "f -1//1 -2//2 \\\n -3//3\no last\nf 1 2 5 4\ns 1\n";
  start_random();
  for (int k = 0; k < 3000; k++) {
    char text[sizeof whole];
    memcpy(text, whole, sizeof whole);
    size_t n = sizeof whole - 1;
    for (int m = 0; m < 3; m++)
      text[(size_t)uniform(0, (double)n)] = "vfgo/-\\\n\r #0123456789.e\xC3\0"[(int)uniform(0, 26)];
    n = k % 4 ? n : (size_t)uniform(0, (double)n);
    struct rad_obj obj;
    struct rad_notes notes;
    struct rad_error e;
    enum rad_code code = read_obj(text, n, &obj, &notes, &e);
    ck_assert(code == RAD_OK || (code == RAD_EINPUT && strstr(e.text, ": error: ")));
    ck_assert(code == RAD_OK || strstr(e.text, "; "));
    rad_obj_free(&obj);
    rad_notes_free(&notes);
  }
}
END_TEST

int main(void) {
  printf("seed %llu (set RAD_TEST_SEED to change)\n", seed());
  Suite *suite = suite_create("obj");
  TCase *reads = tcase_create("reads"), *wrong = tcase_create("bad");
  tcase_add_test(reads, reads_all_forms);
  tcase_add_test(reads, knows_the_lines_of_faces);
  tcase_add_test(reads, names_surfaces_by_one_rule);
  tcase_add_test(reads, cuts_concave_polygons);
  tcase_add_test(reads, cuts_random_polygons);
  tcase_add_test(reads, splits_quadrilaterals_well);
  tcase_add_test(reads, warns_of_bent_faces);
  tcase_add_test(reads, reads_large_files);
  tcase_add_test(reads, reads_one_long_line);
  tcase_add_test(reads, numbers_are_the_nearest_doubles);
  tcase_add_test(reads, numbers_in_another_locale);
  tcase_add_loop_test(wrong, refuses, 0, COUNT(bad));
  tcase_add_test(wrong, refuses_a_zero_byte);
  tcase_add_test(wrong, refuses_a_face_of_very_many_corners);
  tcase_add_test(wrong, unreadable_files);
  tcase_add_test(wrong, damaged_files);
  tcase_set_timeout(reads, 120);
  tcase_set_timeout(wrong, 60);
  suite_add_tcase(suite, reads);
  suite_add_tcase(suite, wrong);
  return run_suite(suite);
}
