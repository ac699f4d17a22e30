#include "base/stop.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>

enum { N_SIGNAL = 2, LOOK_EVERY = 100 /* ms */ };

static const int number_of[N_SIGNAL] = {SIGTERM, SIGUSR1};
static struct sigaction before[N_SIGNAL];
static atomic_int asked; /* lock-free: may be set by a handler and read by any thread */

static void ask(int number) {
  int none = 0;
  atomic_compare_exchange_strong(&asked, &none, number);
}

void rad_stop_on_signals(void) {
  struct sigaction action = {.sa_handler = ask, .sa_flags = SA_RESTART};
  sigset_t both;
  sigemptyset(&action.sa_mask);
  sigemptyset(&both);
  for (int i = 0; i < N_SIGNAL; i++) {
    sigaction(number_of[i], &action, &before[i]);
    sigaddset(&both, number_of[i]);
  }
  sigprocmask(SIG_UNBLOCK, &both, NULL);
}

void rad_stop_release(void) {
  for (int i = 0; i < N_SIGNAL; i++)
    sigaction(number_of[i], &before[i], NULL);
  const int number = atomic_exchange(&asked, 0);
  if (number)
    raise(number);
}

int rad_stop_asked(void) {
  return atomic_load_explicit(&asked, memory_order_relaxed);
}

/* A read would be begun anew after the signal. The flag is looked at again and again, for the
 * signal may come between the look and the wait. */
int rad_stop_await(int fd) {
  struct pollfd p = {.fd = fd, .events = POLLIN};
  for (;;) {
    const int stop = rad_stop_asked();
    const int n = poll(&p, 1, stop ? 0 : LOOK_EVERY);
    if (n > 0 || (n < 0 && errno != EINTR))
      return 1; /* an error is for read to tell */
    if (stop)
      return 0;
  }
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
