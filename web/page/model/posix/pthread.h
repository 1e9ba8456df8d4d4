/* pthread.h: threads where there is one only. None can be started, so that everything is done by
 * who asked for it, in order: locks are free, nothing is ever waited for. */
#ifndef NORMA_WEB_PTHREAD_H
#define NORMA_WEB_PTHREAD_H
#include <errno.h>

typedef int pthread_t, pthread_mutex_t, pthread_cond_t, pthread_attr_t, pthread_mutexattr_t,
    pthread_condattr_t;
#define PTHREAD_MUTEX_INITIALIZER 0
#define PTHREAD_COND_INITIALIZER  0

static inline int pthread_create(
    pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument) {
    (void)thread, (void)attributes, (void)start, (void)argument;
    return EAGAIN;
}
static inline pthread_t pthread_self(void) { return 0; }
static inline int pthread_equal(pthread_t a, pthread_t b) { return a == b; }
static inline int pthread_join(pthread_t thread, void **result) {
    return (void)thread, (void)result, EINVAL;
}
static inline int pthread_mutex_init(
    pthread_mutex_t *mutex, const pthread_mutexattr_t *attributes) {
    return (void)attributes, *mutex = 0;
}
static inline int pthread_mutex_destroy(pthread_mutex_t *mutex) { return (void)mutex, 0; }
static inline int pthread_mutex_lock(pthread_mutex_t *mutex) { return (void)mutex, 0; }
static inline int pthread_mutex_unlock(pthread_mutex_t *mutex) { return (void)mutex, 0; }
static inline int pthread_cond_init(
    pthread_cond_t *condition, const pthread_condattr_t *attributes) {
    return (void)attributes, *condition = 0;
}
static inline int pthread_cond_destroy(pthread_cond_t *condition) { return (void)condition, 0; }
static inline int pthread_cond_signal(pthread_cond_t *condition) { return (void)condition, 0; }
static inline int pthread_cond_broadcast(pthread_cond_t *condition) { return (void)condition, 0; }
/* Nobody could ever wake the one who waits. */
static inline int pthread_cond_wait(pthread_cond_t *condition, pthread_mutex_t *mutex) {
    (void)condition, (void)mutex;
    __builtin_trap();
}
#endif
