/* The deck reader: for each kind of mistake its place and message, and decks that are damaged. */
#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "deck_help.h"
#include "suite.h"

struct bad {
  const char *text;
  int line, column;
  const char *message;
};

#define T(rest) "scene: {triangles: [{vertices: [[0,0,0],[1,0,0],[0,1,0]],\n" rest "}]}\n"

static const struct bad bad[] = {
    /* YAML */
    {"", 1, 1, "the deck is empty"},
    {"# nothing\n", 1, 1, "the deck is empty"},
    {"just a text\n", 1, 1, "the deck is no mapping"},
    {SCENE "title: [1, 2\n", 3, 1, "not valid YAML, did not find expected ',' or ']'"},
    {SCENE "title: \"open\n", 3, 1, "found unexpected end of stream"},
    {SCENE "title: @x\n", 2, 8, "cannot start any token"},
    {"scene:\n\ttriangles: []\n", 2, 1, "a tab in the indentation; use spaces"},
    {"scene: {triangles:\n  \t[]}\n", 2, 3, "a tab in the indentation; use spaces"},
    {"scene:\n  triangles:\n  -\tname: a\n", 3, 4, "a tab in the indentation"},
    {SCENE "title: a\xFFz\n", 2, 9, "byte 0xFF is not UTF-8"},
    {SCENE "title: a\xC0\x80z\n", 2, 9, "byte 0xC0 is not UTF-8"},
    {SCENE "title: \xC3\xBC\x01\n", 2, 9, "control character 0x01"},
    {SCENE "title: \"a\\0b\"\n", 2, 8, "a zero byte"},
    {SCENE "title: \"a\\nb\"\n", 2, 8, "one line of text"},
    {SCENE "---\ntitle: b\n", 2, 1, "a second document"},
    {SCENE "title: &a b\n", 2, 8, "anchors (&a) are not supported"},
    {SCENE "title: *a\n", 2, 8, "aliases (*a) are not supported"},
    {SCENE "title: !!str b\n", 2, 8, "tags (tag:yaml.org,2002:str) are not supported"},
    {SCENE "title: a\ntitle: b\n", 3, 1, "duplicate key 'title', first given on line 2"},
    {SCENE "? [a]\n: b\n", 2, 3, "a key must be a name"},
    {SCENE "title: [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[]]\n", 2, 38, "nested 32 deep; at most 31"},
    {T("a: 1, b: 2, c: 3, d: 4, e: 5, f: 6, g: 7, h: 8, i: 9,\n j: 1, k: 2, l: 3, m: 4, n: 5, "
       "o: 6, p: 7, h: 8"),
     3, 44, "duplicate key 'h', first given on line 2"},
    /* keys and types */
    {SCENE "metod: {elements: 8}\n", 2, 1,
     "unknown key 'metod' in the deck; did you mean 'method'?"},
    {SCENE "qwertyuiop: 1\n", 2, 1, "allowed are title, bands, scene, accuracy, method,"},
    {SCENE "method: {elemnts: 8}\n", 2, 10, "in section 'method'; did you mean 'elements'?"},
    {SCENE "method: {Degree: 8}\n", 2, 10, "did you mean 'degree'?"},
    {SCENE "method: 8\n", 2, 9, "section 'method' is not a mapping"},
    {SCENE "method: {elements: eight}\n", 2, 20, "'elements' is eight; give a whole number from 1"},
    {SCENE "method: {elements: '8'}\n", 2, 20, "'elements' is the text \"8\"; give a whole"},
    {SCENE "method: {elements: [8]}\n", 2, 20, "'elements' is a list of 1; give a whole"},
    {SCENE "method: {elements: {a: 8}}\n", 2, 20, "'elements' is a mapping; give a whole"},
    {SCENE "method:\n  elements:\n", 3, 12, "'elements' is empty; give a whole"},
    {SCENE "method: {elements: 8.5}\n", 2, 20, "a whole number from 1 to 4096"},
    {SCENE "method: {elements: 0x10}\n", 2, 20, "'elements' is 0x10; give a whole"},
    {SCENE "method: {elements: 0}\n", 2, 20, "from 1 to 4096"},
    {SCENE "method: {elements: 4097}\n", 2, 20, "from 1 to 4096"},
    {SCENE "method: {grading: 0.99}\n", 2, 19, "from 1 to 8"},
    {SCENE "method: {grading: .nan}\n", 2, 19, "'grading' is .nan; give a finite number"},
    {SCENE "method: {grading: 1e999}\n", 2, 19, "'grading' is 1e999; give a finite number"},
    {SCENE "method: {degree: 24}\n", 2, 18, "from 0 to 23"},
    {SCENE "method: {constant_layers: -1}\n", 2, 27, "a whole number, 0 or more"},
    {SCENE "method: {quadrature_tolerance: 1e-16}\n", 2, 32, "from 1e-15 to 0.1"},
    {SCENE "method: {solver_tolerance: 1e-3x}\n", 2, 28, "'solver_tolerance' is 1e-3x"},
    {SCENE "method: {solver_tolerance: 1e}\n", 2, 28, "'solver_tolerance' is 1e;"},
    {SCENE "method: {mesh: papr}\n", 2, 16, "'mesh' cannot be 'papr'; did you mean 'paper'?"},
    {SCENE "method: {solver: cholesky}\n", 2, 18, "allowed are auto, lu, gmres, neumann"},
    {SCENE "method: {angle: [polar]}\n", 2, 17, "'angle' is not a name; allowed are polar, duffy"},
    {SCENE "method: {mesh: graded, grading: 1.5}\n", 2, 33, "a whole number, as 'mesh: graded'"},
    {SCENE "method: {nodes: gaus}\n", 2, 17, "did you mean 'gauss'?"},
    {SCENE "method: {degree: 2, nodes: [.9, 1]}\n", 2, 28,
     "'nodes' lists 2 points, but degree 2 has 3 in each direction"},
    {SCENE "method: {nodes: [.9, 1.1]}\n", 2, 22, "from 0 to 1"},
    {SCENE "method: {nodes: [1, .9]}\n", 2, 17, "must ascend by 1e-3 or more; 0.9 follows 1"},
    {SCENE "method: {mesh: uniform, nodes: vertex}\n", 2, 32,
     "'nodes' is for the meshes paper, graded and geometric"},
    {SCENE "method: {mesh: geometric, ratio: 1}\n", 2, 34, "greater than 0 and less than 1"},
    {SCENE "method: {solver: lu, bounces: 3}\n", 2, 31, "'bounces' is for 'solver: neumann' only"},
    {SCENE "method: {solver: neumann, bounces: 100001}\n", 2, 36, "from 0 to 100000"},
    {SCENE "accuracy: {tolerance: 0}\n", 2, 23, "greater than 0 and less than 1"},
    {SCENE "accuracy: {tolerance: 1}\n", 2, 23, "greater than 0 and less than 1"},
    {SCENE "output: {sampling: 65}\n", 2, 20, "from 1 to 64"},
    {SCENE "output: {cells: lagrang}\n", 2, 17, "did you mean 'lagrange'?"},
    {SCENE "output: {fields: [radiance]}\n", 2, 19, "did you mean 'irradiance'?"},
    {SCENE "output: {fields: [radiosity, radiosity]}\n", 2, 30, "is named twice"},
    {SCENE "output: {fields: radiosity}\n", 2, 18, "give a list of radiosity, irradiance"},
    {SCENE "output: {file: ''}\n", 2, 16, "'file' is the text \"\"; give a text"},
    {"bands: [a, b, a]\n" SCENE, 1, 15, "band 'a' is named twice"},
    {"bands: []\n" SCENE, 1, 8, "a list of 1 to 16 names"},
    {"bands: [a,b,c,d,e,f,g,h,i,j,k,l,m,n,o,p,q]\n" SCENE, 1, 8, "a list of 1 to 16 names"},
    {SCENE "probes: {at: [0, 0, 0]}\n", 2, 9, "'probes' is a mapping; give a list"},
    {SCENE "probes:\n- name: a\n", 3, 3, "the probe has no 'at'"},
    {SCENE "probes:\n- at: [0, 0]\n", 3, 7, "'at' is a list of 2; give a list of 3 numbers"},
    /* scene */
    {"title: a\n", 1, 1, "there is no 'scene'"},
    {"scene: {surfaces: {}}\n", 1, 8, "the scene is empty; give 'triangles'"},
    {"scene: {triangles: []}\n", 1, 20, "a list of at least one triangle"},
    {"scene: {mesh: {scale: 1}}\n", 1, 15, "'scene.mesh' has no 'file'"},
    {"scene: {mesh: {file: a.obj, scale: 0}}\n", 1, 36, "a finite number greater than 0"},
    {"scene:\n  triangles:\n  - rho: 1\n", 3, 5, "the triangle has no 'vertices'"},
    {"scene: {triangles: [{vertices: [[0,0,0],[1,0,0]]}]}\n", 1, 32,
     "is a list of 2; give 3 points"},
    {"scene: {triangles: [{vertices: [[0,0,0],[1,0],[0,1,0]]}]}\n", 1, 41, "a list of 3 numbers"},
    {"scene: {triangles: [{vertices: [[0,0,0],[1,0,x],[0,1,0]]}]}\n", 1, 46, "'vertices' is x;"},
    {T("vertexes: 1"), 2, 1, "unknown key 'vertexes' in a triangle; did you mean 'vertices'?"},
    {T("rho: 1.01"), 2, 6, "a finite number from 0 to 1"},
    {T("rho: -0.01"), 2, 6, "a finite number from 0 to 1"},
    {T("rho: [0.5, 0.5]"), 2, 6, "'rho' has 2 numbers but there are 1 bands"},
    {T("emission: -1"), 2, 11, "a finite number, 0 or more"},
    {T("emission: {vertices: [1, 2]}"), 2, 22, "{vertices: [E0, E1, E2]}"},
    {T("emission: {vertices: [1, 2, -3]}"), 2, 29, "'emission' is -3"},
    {T("emission: {vertex: [1, 2, 3]}"), 2, 12, "unknown key 'vertex' in 'emission'; allowed are"},
    {T("emission: {}"), 2, 11, "{vertices: [E0, E1, E2]}"},
    {T("normal: [0, 0, 0]"), 2, 9, "a direction that is not zero"},
    {T("normal: [0, 0, 1],\n side: front"), 3, 8, "both 'normal' and 'side' are given"},
    {T("side: frnt"), 2, 7, "did you mean 'front'?"},
    {T("name: "), 2, 7, "'name' is empty; give a text"},
    {T("grading: [1, 2]"), 2, 10, "1, 3 (edges) or 6 (sub-triangles) numbers"},
    {T("grading: [1, 2, 0.5]"), 2, 17, "from 1 to 8"},
    {T("grading: [1, 1, 1.5]") "method: {mesh: graded}\n", 2, 17, "as 'mesh: graded' needs"},
    {T("elements: [1, 2, 3]"), 2, 11, "1 or 6 (sub-triangles) whole numbers"},
    {T("elements: 0"), 2, 11, "a whole number from 1 to 4096"},
    {"scene: {mesh: {file: a}, surfaces: {lamp: {rho: 2}}}\n", 1, 49, "from 0 to 1"},
    /* heat radiation */
    {T("rho: 1, emissivity: 0"), 2, 21, "'rho' and 'emissivity' exclude each other; give rho and"},
    {T("temperature: 300, rho: 1"), 2, 14, "'rho' and 'temperature' exclude each other"},
    {T("emission: 1, flux: 0"), 2, 20, "'emission' and 'flux' exclude each other"},
    {T("emissivity: 1, emission: 1"), 2, 13, "'emissivity' exclude each other"},
    {T("emissivity: 1, temperature: 3, flux: 0"), 2, 38, "'temperature' and 'flux' exclude"},
    {T("emissivity: 1.1, flux: 0"), 2, 13, "a finite number from 0 to 1"},
    {T("emissivity: 1, temperature: -1"), 2, 29, "'temperature' is -1; give a finite number, 0 or"},
    {T("emissivity: 1, flux: hot"), 2, 22, "'flux' is hot; give a finite number"},
    {T("emissivity: [1], flux: 0"), 2, 13, "'emissivity' is a list of 1"},
    {"bands: [a, b]\n" T("emissivity: 1, flux: 0"), 3, 13,
     "'emissivity' is for grey radiation, but the deck has 2 bands; remove 'bands', or give rho"},
    {"scene: {mesh: {file: a}, surfaces: {lamp: {temperature: 9, emission: 2}}}\n", 1, 57,
     "'emission' and 'temperature' exclude"},
    {"scene: {mesh: {file: a}, surfaces: {lamp: {rh: 2}}}\n", 1, 44, "in a surface; did you mean"},
    {"scene: {mesh: {file: a}, surfaces: {lamp: {emission: {vertices: [1,1,1]}}}}\n", 1, 54,
     "values by vertex belong to a triangle"},
    {"scene: {mesh: {file: a}, surfaces: [lamp]}\n", 1, 36, "'surfaces' is a list of 1; give a"},
    /* study */
    {SCENE "study: {reference: last}\n", 2, 8, "the study has no 'vary'"},
    {SCENE "study: {vary: {}}\n", 2, 15, "'vary' is a mapping; give a mapping"},
    {SCENE "study: {vary: {method.elements: 8}}\n", 2, 33, "give a list of the values to run"},
    {SCENE "study: {vary: {method.elements: []}}\n", 2, 33, "is a list of 0"},
    {SCENE "study: {vary: {method.elemnts: [8]}}\n", 2, 16, "did you mean 'elements'?"},
    {SCENE "study: {vary: {method.elements: [8, 0]}}\n", 2, 37, "'elements' is 0;"},
    {SCENE "study: {vary: {scene.triangles.1.rho: [0]}}\n", 2, 16,
     "is a list of 1, numbered from 0"},
    {SCENE "output: {camera: {angel: 40}}\n", 2, 19, "did you mean 'angle'"},
    {SCENE "output: {camera: {angle: 171}}\n", 2, 26, "'angle' is 171;"},
    {SCENE "output: {camera: {from: [0, 1]}}\n", 2, 25, "a list of 3 numbers"},
    {SCENE "study: {vary: {study.vary: [0]}}\n", 2, 16, "a study cannot vary 'study'"},
    {SCENE "study: {vary: {method.elements: [8]}, values: u}\n", 2, 47, "'values' cannot be 'u'"},
    {SCENE "study: {vary: {method.elements: [8]}, repeats: 0}\n", 2, 48, "a whole number from 1"},
    {SCENE "study: {vary: {method.elements: [8]}, reference: {tolerance: 2}}\n", 2, 62,
     "'tolerance' is 2;"},
    {SCENE "method: {grading: 1.5}\nstudy: {vary: {method.mesh: [paper, graded]}}\n", 3, 37,
     "in the study with method.mesh=graded: 'grading' is 1.5"},
    {T("grading: 1.5") "study: {vary: {method.mesh: [paper, graded]}}\n", 3, 37, "(line 2)"},
    {SCENE "study: {vary: {method.mesh: [paper, graded], method.grading: [1, 1.5]}}\n", 2, 66,
     "'grading' is 1.5; give a whole number"},
    {"bands: [a]\n" T("rho: [0.5]") "study: {vary: {bands: [[a, b]]}}\n", 4, 24,
     "in the study with bands=[a, b]: 'rho' has 1 numbers"},
    {SCENE "study: {vary: {method.elements: [8]}, reference: frst}\n", 2, 50,
     "'reference' cannot be 'frst'; did you mean 'last'?"},
    {SCENE "study: {vary: {method.elements: [8]}, reference: {elemnts: 1}}\n", 2, 51,
     "unknown key 'elemnts' in section 'method'; did you mean 'elements'?"},
    {SCENE "study: {vary: {method.elements: [8]}, reference: {mesh: graded, grading: 1.5}}\n", 2,
     74, "'grading' is 1.5"},
};

static void check_place(const struct bad *b, const char *text) {
  char place[96];
  snprintf(place, sizeof place, "%s:%d:", deck_path, b->line);
  size_t n = strlen(place);
  ck_assert_msg(!strncmp(text, place, n), "expected %s, got: %s", place, text);
  char *end;
  long column = strtol(text + n, &end, 10);
  ck_assert_msg(!strncmp(end, ": error: ", 9), "no 'error:' after the place: %s", text);
  ck_assert_msg(column == b->column, "expected column %d: %s", b->column, text);
}

START_TEST(refused) {
  const struct bad *b = &bad[_i];
  struct rad_deck d;
  struct rad_error e;
  enum rad_code code = read_text(b->text, 0, NULL, &d, &e);
  rad_deck_free(&d);
  ck_assert_msg(code == RAD_EINPUT, "code %d for the deck\n%s", code, b->text);
  ck_assert_msg(strstr(e.text, b->message), "no \"%s\" in: %s", b->message, e.text);
  ck_assert_msg(!strchr(e.text, '\n'), "more than one line: %s", e.text);
  ck_assert_msg(strstr(e.text, "; ") || strchr(e.text, ','), "no remedy: %s", e.text);
  check_place(b, e.text);
}
END_TEST

START_TEST(zero_byte_in_the_file) {
  static const char text[] = "title: a\0b\n" SCENE;
  write_deck(text, sizeof text - 1);
  struct rad_deck d;
  struct rad_error e;
  ck_assert_int_eq(rad_deck_read(deck_path, 0, NULL, &d, &e), RAD_EINPUT);
  rad_deck_free(&d);
  unlink(deck_path);
  ck_assert_msg(strstr(e.text, ":1:9: error: control character 0x00"), "%s", e.text);
}
END_TEST

START_TEST(unreadable_file) {
  static const struct {
    const char *path, *reason;
  } no[] = {{"/nonexistent/deck.yml", "No such file or directory"}, {"/tmp", "Is a directory"}};
  for (int i = 0; i < COUNT(no); i++) {
    struct rad_deck d;
    struct rad_error e;
    ck_assert_int_eq(rad_deck_read(no[i].path, 0, NULL, &d, &e), RAD_ESYSTEM);
    rad_deck_free(&d);
    ck_assert_msg(strstr(e.text, no[i].path) == e.text, "%s", e.text);
    ck_assert_msg(strstr(e.text, no[i].reason), "%s", e.text);
  }
}
END_TEST

static const struct {
  const char *set, *message;
} bad_set[] = {
    {"method.elemnts=8", "unknown key 'elemnts' in section 'method'; did you mean 'elements'?"},
    {"metod.elements=8", "unknown key 'metod' in the deck; did you mean 'method'?"},
    {"method.elements=0", "'elements' is 0; give a whole number from 1 to 4096"},
    {"method.elements=", "'elements' is empty"},
    {"method.elements.x=8", "'method.elements' is a single value and has no 'x'"},
    {"method.elements=[1", "not valid YAML"},
    {"method.elements=*a", "aliases"},
    {"method.elements", "there is no '='"},
    {"=8", "'' is no dotted key"},
    {"method..elements=8", "'method..elements' is no dotted key"},
    {"scene.triangles.1.rho=0.5", "'scene.triangles' is a list of 1, numbered from 0; '1' is not"},
    {"scene.triangles.x.rho=0.5", "'x' is not in it"},
    {"scene.triangles.0.rho=1.5", "'rho' is 1.5"},
    {"scene.triangles=", "'triangles' is empty"},
    {"title=a: b", "'title' is a mapping"},
    {"a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a=1", "the key has 33 parts"},
};

START_TEST(refused_overrides) {
  const char *set[2] = {"method.degree=2", bad_set[_i].set};
  struct rad_deck d;
  struct rad_error e;
  enum rad_code code = read_text(SCENE "method: {elements: 8}\n", 2, set, &d, &e);
  rad_deck_free(&d);
  ck_assert_int_eq(code, RAD_EINPUT);
  char start[120];
  snprintf(start, sizeof start, "--set %s: error: ", bad_set[_i].set);
  ck_assert_msg(!strncmp(e.text, start, strlen(start)), "expected %s..., got %s", start, e.text);
  ck_assert_msg(strstr(e.text, bad_set[_i].message), "%s", e.text);
}
END_TEST

/* An override that spoils another key of the deck: the place is that key's. */
START_TEST(override_against_the_deck) {
  const char *set = "method.mesh=graded";
  struct rad_deck d;
  struct rad_error e;
  ck_assert_int_eq(read_text(SCENE "method: {grading: 1.5}\n", 1, &set, &d, &e), RAD_EINPUT);
  rad_deck_free(&d);
  ck_assert_msg(strstr(e.text, ":2:19: error: 'grading' is 1.5"), "%s", e.text);
}
END_TEST

/* Cuts and flips bytes of the full deck: any answer is fine, but never a crash or a leak. */
START_TEST(damaged_decks) {
  unsigned seed = 12345;
  printf("damaged_decks: seed %u\n", seed);
  size_t n = strlen(full_deck);
  for (int i = 0; i < 600; i++) {
    char text[FULL_DECK];
    memcpy(text, full_deck, n);
    size_t length = n;
    for (int k = 0; k < 3; k++) {
      seed = seed * 1664525u + 1013904223u;
      text[(seed >> 8) % n] = "[]{},:-'\"#&*!|>%@`\t\n 0z\xFF"[(seed >> 4) % 24];
    }
    if (i % 4 == 0)
      length = (seed >> 8) % n;
    write_deck(text, length);
    struct rad_deck d;
    struct rad_error e = {.code = RAD_OK};
    enum rad_code code = rad_deck_read(deck_path, 0, NULL, &d, &e);
    rad_deck_free(&d);
    ck_assert(code == RAD_OK || code == RAD_EINPUT);
    ck_assert(code == RAD_OK || strstr(e.text, ": error: "));
  }
  unlink(deck_path);
}
END_TEST

/* Many names in one mapping, none twice: found without comparing all pairs (10^10 would show). */
START_TEST(many_surfaces) {
  enum { N = 100000 };
  char *text = malloc(N * 24 + 64), *s = text;
  s += sprintf(s, "scene:\n  mesh: {file: a.obj}\n  surfaces:\n");
  for (int i = 0; i < N; i++)
    s += sprintf(s, "    s%d: {rho: 0}\n", i);
  struct rad_deck d;
  read_good(text, 0, NULL, &d);
  ck_assert_int_eq(d.n_surface, N);
  ck_assert_str_eq(d.surface[N - 1].name, "s99999");
  rad_deck_free(&d);
  sprintf(s, "    s77: {rho: 0}\n");
  struct rad_error e;
  ck_assert_int_eq(read_text(text, 0, NULL, &d, &e), RAD_EINPUT);
  rad_deck_free(&d);
  free(text);
  ck_assert_msg(strstr(e.text, ":100004:5: error: duplicate key 's77', first given on line 81"),
                "%s", e.text);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("deck errors");
  TCase *wrong = tcase_create("bad"), *hard = tcase_create("hard");
  tcase_add_loop_test(wrong, refused, 0, COUNT(bad));
  tcase_add_test(wrong, zero_byte_in_the_file);
  tcase_add_test(wrong, unreadable_file);
  tcase_add_loop_test(wrong, refused_overrides, 0, COUNT(bad_set));
  tcase_add_test(wrong, override_against_the_deck);
  tcase_add_test(hard, damaged_decks);
  tcase_add_test(hard, many_surfaces);
  tcase_set_timeout(hard, 60);
  suite_add_tcase(suite, wrong);
  suite_add_tcase(suite, hard);
  return run_suite(suite);
}
