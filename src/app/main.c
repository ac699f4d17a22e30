/* Arguments in, exit code out; everything else is in the library. */
#include <math.h>
#include <omp.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "app/command.h"
#include "base/number.h"
#include "base/provenance.h"
#include "base/stop.h"
#include "base/streams.h"

static const char usage[] =
    "polyrad: diffuse radiosity of scenes made of plane triangles\n"
    "\n"
    "  polyrad run DECK   [-o FILE] [--set KEY=VALUE]... [--threads N] [--quiet]\n"
    "                     [--checkpoint FILE] [--restart FILE]\n"
    "  polyrad check DECK [--set KEY=VALUE]... [--threads N]\n"
    "  polyrad study DECK [-o FILE] [--set KEY=VALUE]... [--threads N] [--quiet]\n"
    "                     [--tasks | --task I/N]\n"
    "  polyrad study --collect FILE... [-o FILE] [--quiet]\n"
    "  polyrad assemble DECK --part I/N [-o FILE] [--set KEY=VALUE]... [--threads N] [--quiet]\n"
    "  polyrad solve DECK --parts FILE... [-o FILE] [--set KEY=VALUE]... [--threads N] [--quiet]\n"
    "                     [--checkpoint FILE] [--restart FILE]\n"
    "  polyrad info FILE\n"
    "  polyrad --help | --version\n"
    "\n"
    "run    solve the deck, write FILE, print a summary\n"
    "check  read and validate; print sizes, predicted memory and time; solve nothing\n"
    "study  run a sweep, print its table with estimated orders (EOC), write it\n"
    "assemble  write one part of the matrix, so that many machines share the work\n"
    "solve  like run, with a matrix from the files of all parts\n"
    "info   say what a result file holds\n"
    "\n"
    "  -o FILE          where to write (default: output.file of the deck)\n"
    "  --set KEY=VALUE  override one key of the deck, for example method.elements=8\n"
    "  --threads N      OpenMP threads (default: OMP_NUM_THREADS, then all cores)\n"
    "  --quiet          no summary\n"
    "  --tasks          only name the result files of the study's runs, one a line\n"
    "  --task I/N       only the I-th of the study's N runs, into a result file of its own\n"
    "  --collect        the table from the result files of all tasks\n"
    "  --part I/N       the I-th of N parts of the matrix\n"
    "  --parts          the files that follow are all parts of the matrix\n"
    "  --checkpoint FILE  on SIGTERM or SIGUSR1 write what is done to FILE and exit with 85\n"
    "  --restart FILE     go on from such a FILE; that of --checkpoint need not exist yet\n"
    "\n"
    "Exit codes: 0 done, 1 not converged or singular, 2 deck or usage, 3 file, memory or device,\n"
    "85 stopped, and a checkpoint is written: give the command again with --restart.\n";

typedef enum rad_code verb_function(const struct rad_command *, struct rad_error *);

struct verb {
  const char *name;
  verb_function *function;
  const char *operand;
  int writes; /* a signal is to find no half-written file, and may leave a checkpoint */
};

static const struct verb verbs[] = {
    {"run", rad_app_run, "DECK", 1},     {"check", rad_app_check, "DECK", 0},
    {"study", rad_app_study, "DECK", 1}, {"assemble", rad_app_assemble, "DECK", 1},
    {"solve", rad_app_solve, "DECK", 1}, {"info", rad_app_info, "FILE", 0}};

/* The value of an option: the rest of the word after '=', or the next word. */
static const char *value_of(int argc, char **argv, int *i, size_t name_length) {
  if (argv[*i][name_length] == '=')
    return argv[*i] + name_length + 1;
  return *i + 1 < argc ? argv[++*i] : NULL;
}

static int is_option(const char *word, const char *name) {
  size_t n = strlen(name);
  return !strncmp(word, name, n) && (word[n] == 0 || word[n] == '=');
}

static enum rad_code parse_threads(const char *text, int *threads, struct rad_error *e) {
  const char *end = text;
  int n = text ? rad_whole_parse(&end) : 0;
  if (!text || *end || n < 1 || n > 4096)
    return rad_fail(e, RAD_EINPUT, "error: --threads needs a whole number from 1 to 4096, got '%s'",
                    text ? text : "nothing");
  *threads = n;
  return RAD_OK;
}

/* I/N, as in --task 2/5. */
static enum rad_code parse_share(const char *text, const char *option, int *i, int *n,
                                 struct rad_error *e) {
  const char *end = text;
  *i = text ? rad_whole_parse(&end) : -1;
  *n = text && *end++ == '/' ? rad_whole_parse(&end) : -1;
  if (*i < 1 || *i > *n || *end)
    return rad_fail(e, RAD_EINPUT, "error: %s needs I/N, for example 2/5, got '%s'", option,
                    text ? text : "nothing");
  return RAD_OK;
}

/* Options that only one verb has; *known is 0 for others. */
static enum rad_code parse_own_word(int argc, char **argv, int *i, struct rad_command *c,
                                    int *known, struct rad_error *e) {
  const char *word = argv[*i];
  int studies = !strcmp(c->verb, "study");
  *known = 1;
  if (studies && !strcmp(word, "--tasks"))
    c->lists = 1;
  else if (studies && !strcmp(word, "--collect"))
    c->collects = 1;
  else if (studies && is_option(word, "--task"))
    return parse_share(value_of(argc, argv, i, 6), "--task", &c->task, &c->n_task, e);
  else if (!strcmp(c->verb, "assemble") && is_option(word, "--part"))
    return parse_share(value_of(argc, argv, i, 6), "--part", &c->part, &c->n_part, e);
  else if (!strcmp(c->verb, "solve") && !strcmp(word, "--parts") && c->n_file == 1)
    c->joins = 1;
  else
    *known = 0;
  return RAD_OK;
}

static enum rad_code parse_file(const char *text, const char *option, const char **file,
                                struct rad_error *e) {
  if (!text || !*text)
    return rad_fail(e, RAD_EINPUT, "error: %s needs a file name", option);
  *file = text;
  return RAD_OK;
}

/* One word of the command line after the verb. */
static enum rad_code parse_word(int argc, char **argv, int *i, struct rad_command *c,
                                struct rad_error *e) {
  const char *word = argv[*i];
  int known;
  enum rad_code code = parse_own_word(argc, argv, i, c, &known, e);
  if (known)
    return code;
  if (!strcmp(word, "--quiet")) {
    c->quiet = 1;
  } else if (is_option(word, "-o")) {
    if (!(c->output = value_of(argc, argv, i, 2)) || !*c->output)
      return rad_fail(e, RAD_EINPUT, "error: -o needs a file name");
  } else if (is_option(word, "--set")) {
    const char *value = value_of(argc, argv, i, 5);
    if (!value || c->n_set == RAD_MAX_SET)
      return rad_fail(e, RAD_EINPUT,
                      value ? "error: more than 256 --set options"
                            : "error: --set needs KEY=VALUE, for example "
                              "--set method.elements=8");
    c->set[c->n_set++] = value;
  } else if (is_option(word, "--threads")) {
    return parse_threads(value_of(argc, argv, i, 9), &c->threads, e);
  } else if (is_option(word, "--checkpoint")) {
    return parse_file(value_of(argc, argv, i, 12), "--checkpoint", &c->checkpoint, e);
  } else if (is_option(word, "--restart")) {
    return parse_file(value_of(argc, argv, i, 9), "--restart", &c->restart, e);
  } else if (word[0] == '-' && word[1]) {
    return rad_fail(e, RAD_EINPUT, "error: unknown option '%s'; polyrad --help lists them", word);
  } else {
    c->file[c->n_file++] = word;
  }
  return RAD_OK;
}

/* The command as typed, one string; owned by the caller. */
static char *join(int argc, char **argv) {
  size_t length = 1;
  for (int i = 0; i < argc; i++)
    length += strlen(argv[i]) + 1;
  char *line = calloc(length, 1);
  for (int i = 0; line && i < argc; i++) {
    strcat(line, i ? " " : "");
    strcat(line, argv[i]);
  }
  return line;
}

static int print_version(void) {
  struct rad_provenance p = {0};
  rad_provenance_get(&p);
  printf("polyrad %s (%s)\n%s\n%s%s\n", p.version, p.git_revision, p.compiler, p.blas,
         p.blas_parallel == 2 ? "" : " (not the OpenMP flavour: LU and products may be slower)");
  return RAD_OK;
}

/* Files that are named without an option: one, but any number of tasks to collect, or parts. */
static enum rad_code check_files(const struct verb *verb, struct rad_command *c,
                                 struct rad_error *e) {
  if (!c->n_file)
    return rad_fail(e, RAD_EINPUT, "error: polyrad %s needs a %s; polyrad --help shows how",
                    verb->name, c->collects ? "FILE after --collect" : verb->operand);
  if (c->n_file > 1 && !c->collects && !c->joins)
    return rad_fail(e, RAD_EINPUT, "error: one file at a time, but got '%s' and '%s'", c->file[0],
                    c->file[1]);
  if ((c->checkpoint || c->restart) && strcmp(c->verb, "run") != 0 && !c->joins && !c->n_task)
    return rad_fail(
        e, RAD_EINPUT, /* not heeded, it would be missed when it is too late */
        "error: --checkpoint and --restart are for polyrad run, solve and study --task; "
        "polyrad %s has no checkpoints",
        c->verb);
  c->deck = c->file[0];
  return RAD_OK;
}

static enum rad_code run_verb(const struct verb *verb, int argc, char **argv, struct rad_error *e) {
  struct rad_command c = {.verb = verb->name, .out = stdout, .log = stderr};
  char *line = join(argc, argv);
  enum rad_code code = RAD_OK;
  int asks_help = 0;
  c.file = calloc(argc > 0 ? (size_t)argc : 1, sizeof *c.file);
  if (!line || !c.file)
    code = rad_fail(e, RAD_ESYSTEM, "error: out of memory for the command line");
  for (int i = 2; i < argc && !code && !asks_help; i++) {
    asks_help = !strcmp(argv[i], "--help") || !strcmp(argv[i], "-h");
    if (!asks_help)
      code = parse_word(argc, argv, &i, &c, e);
  }
  if (asks_help && !code)
    fputs(usage, stdout);
  else if (!code && !(code = check_files(verb, &c, e))) {
    if (c.threads)
      omp_set_num_threads(c.threads);
    c.line = line;
    code = verb->function(&c, e);
  }
  free(c.file);
  free(line);
  return code;
}

/* NULL: there is none of that name. */
static const struct verb *find_verb(const char *word) {
  for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++)
    if (!strcmp(word, verbs[i].name))
      return &verbs[i];
  return NULL;
}

/* The exit code, once all that was printed is where it was to go. */
static int finish(int code) {
  struct rad_error e;
  if (rad_streams_end(&e) && code == RAD_OK) {
    fprintf(stderr, "%s\n", e.text);
    return RAD_ESYSTEM;
  }
  return code;
}

int main(int argc, char **argv) {
  rad_stop_on_signals(); /* before all else: no signal is to find a run that is not ready for it */
  struct rad_error e = {0};
  rad_streams_begin();
#ifdef SIGXFSZ
  signal(SIGXFSZ, SIG_IGN); /* a file size limit is then an error of write, and told as one */
#endif
  const char *word = argc > 1 ? argv[1] : "--help";
  const struct verb *verb = find_verb(word);
  if (!verb || !verb->writes)
    rad_stop_release();
  if (!strcmp(word, "--version"))
    return finish(print_version());
  if (!strcmp(word, "--help") || !strcmp(word, "-h")) {
    fputs(usage, argc > 1 ? stdout : stderr);
    return finish(argc > 1 ? RAD_OK : RAD_EINPUT);
  }
  if (!verb) {
    fprintf(stderr, "error: unknown command '%s'; polyrad --help lists them\n", word);
    return finish(RAD_EINPUT);
  }
  enum rad_code code = run_verb(verb, argc, argv, &e);
  if (code)
    fprintf(stderr, "%s\n", e.text);
  if (code == RAD_ESTOPPED)
    rad_stop_die();
  return finish(code);
}
