#include "base/stop.h"

#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>

static atomic_int asked; /* lock-free: may be set by a handler and read by any thread */

static void ask(int number) {
  int none = 0;
  atomic_compare_exchange_strong(&asked, &none, number);
}

void rad_stop_on_signals(void) {
  struct sigaction action = {.sa_handler = ask, .sa_flags = SA_RESTART};
  sigemptyset(&action.sa_mask);
  sigaction(SIGTERM, &action, NULL);
  sigaction(SIGUSR1, &action, NULL);
}

int rad_stop_asked(void) {
  return atomic_load_explicit(&asked, memory_order_relaxed);
}

const char *rad_stop_name(void) {
  return rad_stop_asked() == SIGUSR1 ? "SIGUSR1" : "SIGTERM";
}

enum rad_code rad_fail_stopped(struct rad_error *e) {
  return rad_fail(e, RAD_ESTOPPED, "stopped by %s; nothing is written", rad_stop_name());
}

void rad_stop_die(void) {
  int number = rad_stop_asked();
  if (!number)
    return;
  signal(number, SIG_DFL);
  raise(number);
}
