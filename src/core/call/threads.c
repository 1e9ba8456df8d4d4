/* threads.c: tasks by index, over the caller's jobs or over threads of our own. What a task
 * computes never depends on who runs it. A call of several steps keeps its threads from one to the
 * next, since to begin one takes as long as the normals of a thousand triangles. */
#define _GNU_SOURCE /* sched_getaffinity */
#include "core/call/call.h"

enum { MOST_WORKERS = 256 };

typedef struct pool {
    core_call *call;
    norma_task *task;
    void *context;
    size_t count;
} pool;

static norma_result run_in_order(const pool *c) {
    for (size_t i = 0; i < c->count; ++i) {
        if (norma_core_progress(c->call, (double)i / (double)c->count)) return NORMA_CANCELLED;
        c->task(c->context, i);
    }
    return norma_core_progress(c->call, 1) ? NORMA_CANCELLED : NORMA_OK;
}

static norma_result run_in_callers_jobs(const pool *c) {
    if (norma_core_progress(c->call, 0)) return NORMA_CANCELLED;
    c->call->options.parallel_for(
        c->call->options.parallel_for_user, c->count, c->task, c->context);
    return norma_core_progress(c->call, 1) ? NORMA_CANCELLED : NORMA_OK;
}

#if defined(__wasm__) || defined(_MSC_VER) /* neither has pthreads: a parallel_for serves there */
static norma_result run_in_threads(const pool *c, size_t workers) {
    (void)workers;
    return run_in_order(c);
}
static size_t machine_threads(void) { return 1; }
void norma_core_gather(core_call *call) { (void)call; }
void norma_core_dismiss(core_call *call) { (void)call; }
#else
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

typedef struct thread_pool {
    const pool *work;
    atomic_size_t next, done;
    atomic_size_t ended; /* helpers */
    atomic_int stop;
} thread_pool;

static int take_one(thread_pool *t) {
    if (atomic_load_explicit(&t->stop, memory_order_relaxed)) return 0;
    const size_t index = atomic_fetch_add_explicit(&t->next, 1, memory_order_relaxed);
    if (index >= t->work->count) return 0;
    t->work->task(t->work->context, index);
    atomic_fetch_add_explicit(&t->done, 1, memory_order_relaxed);
    return 1;
}

static void *help_pool(void *pool_of_threads) {
    thread_pool *t = pool_of_threads;
    while (take_one(t)) {
    }
    atomic_fetch_add_explicit(&t->ended, 1, memory_order_release);
    return NULL;
}

/* ---- threads that stay for a whole call */

struct core_team {
    pthread_mutex_t lock;
    pthread_cond_t wake;
    atomic_uint round;  /* odd while there are tasks to take, changed under the lock */
    atomic_uint inside; /* helpers that may be at tasks of the round */
    _Atomic(thread_pool *) work;
    atomic_int over;
    size_t started;
    pthread_t threads[MOST_WORKERS];
};

/* The next step of most calls follows at once; to sleep and to be woken takes longer. */
static unsigned wait_for_round(core_team *team, unsigned seen) {
    enum { LOOKS = 256 };
    for (int looks = 0; looks < LOOKS; ++looks) {
        const unsigned round = atomic_load_explicit(&team->round, memory_order_acquire);
        if (round != seen) return round;
        sched_yield();
    }
    pthread_mutex_lock(&team->lock);
    while (atomic_load_explicit(&team->round, memory_order_relaxed) == seen)
        pthread_cond_wait(&team->wake, &team->lock);
    const unsigned round = atomic_load_explicit(&team->round, memory_order_relaxed);
    pthread_mutex_unlock(&team->lock);
    return round;
}

/* Who enters looks again whether the round goes on: who ends it waits for all that saw it go on.
 * One that wakes too late keeps nobody waiting. */
static void *stay(void *context) {
    core_team *team = context;
    for (unsigned seen = 0;;) {
        seen = wait_for_round(team, seen);
        if (atomic_load_explicit(&team->over, memory_order_relaxed)) return NULL;
        if (seen % 2 == 0) continue;
        atomic_fetch_add(&team->inside, 1);
        if (atomic_load(&team->round) == seen) {
            thread_pool *t = atomic_load_explicit(&team->work, memory_order_relaxed);
            while (take_one(t)) {
            }
        }
        atomic_fetch_sub_explicit(&team->inside, 1, memory_order_release);
    }
}

static void next_round(core_team *team) {
    pthread_mutex_lock(&team->lock);
    atomic_fetch_add(&team->round, 1);
    pthread_cond_broadcast(&team->wake);
    pthread_mutex_unlock(&team->lock);
}

void norma_core_gather(core_call *call) {
    const size_t helpers = norma_core_workers(call) - 1;
    if (call->options.parallel_for || helpers == 0) return;
    core_team *team = norma_core_allocate(call, 1, sizeof *team);
    if (!team) return; /* each step begins threads of its own */
    pthread_mutex_init(&team->lock, NULL);
    pthread_cond_init(&team->wake, NULL);
    atomic_init(&team->round, 0);
    atomic_init(&team->inside, 0);
    atomic_init(&team->work, NULL);
    atomic_init(&team->over, 0);
    for (team->started = 0; team->started < helpers; ++team->started)
        if (pthread_create(&team->threads[team->started], NULL, stay, team) != 0) break;
    call->team = team;
}

void norma_core_dismiss(core_call *call) {
    core_team *team = call->team;
    if (!team) return;
    call->team = NULL;
    atomic_store_explicit(&team->over, 1, memory_order_relaxed); /* seen with the round */
    next_round(team);
    for (size_t i = 0; i < team->started; ++i) pthread_join(team->threads[i], NULL);
    pthread_cond_destroy(&team->wake);
    pthread_mutex_destroy(&team->lock);
    norma_core_release(call, team, 1, sizeof *team);
}

static void tell_progress(thread_pool *t) {
    const size_t done = atomic_load_explicit(&t->done, memory_order_relaxed);
    if (norma_core_progress(t->work->call, (double)done / (double)t->work->count))
        atomic_store_explicit(&t->stop, 1, memory_order_relaxed);
}

/* A helper's last task may be long, and the caller may want to stop it meanwhile. */
enum { WAITS_A_QUESTION = 1 << 14 }; /* some milliseconds */
static void wait_for_helpers(thread_pool *t, size_t started) {
    for (int waits = 1; atomic_load_explicit(&t->ended, memory_order_acquire) < started;
         waits = waits % WAITS_A_QUESTION + 1) {
        sched_yield();
        if (waits == WAITS_A_QUESTION) tell_progress(t);
    }
}

static void run_by_team(core_team *team, thread_pool *shared) {
    atomic_store_explicit(&team->work, shared, memory_order_relaxed);
    next_round(team);
    do tell_progress(shared);
    while (take_one(shared));
    atomic_fetch_add(&team->round, 1);
    for (size_t waits = 1; atomic_load(&team->inside); ++waits) {
        sched_yield();
        if (waits % WAITS_A_QUESTION == 0) tell_progress(shared);
    }
}

/* The calling thread works as the others do, and alone talks to the caller. A thread that cannot be
 * had is done without. */
static norma_result run_in_threads(const pool *c, size_t workers) {
    pthread_t threads[MOST_WORKERS];
    thread_pool shared = {.work = c};
    size_t started = 0;
    if (c->call->team) {
        run_by_team(c->call->team, &shared);
    } else {
        while (started + 1 < workers &&
               pthread_create(&threads[started], NULL, help_pool, &shared) == 0)
            ++started;
        do tell_progress(&shared);
        while (take_one(&shared));
        if (c->call->options.progress) wait_for_helpers(&shared, started);
        for (size_t i = 0; i < started; ++i) pthread_join(threads[i], NULL);
    }
    if (c->call->cancelled) return NORMA_CANCELLED;
    return norma_core_progress(c->call, 1) ? NORMA_CANCELLED : NORMA_OK;
}

/* Those on which this thread may run are known to the system without a look at files, as sysconf
 * takes one. */
static size_t machine_threads(void) {
#if defined(_WIN32)
    const int online = pthread_num_processors_np();
#elif defined(__linux__)
    cpu_set_t set;
    const long online = sched_getaffinity(0, sizeof set, &set) == 0 ? (long)CPU_COUNT(&set)
                                                                    : sysconf(_SC_NPROCESSORS_ONLN);
#else
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
#endif
    return online > 0 ? (size_t)online : 1;
}

#endif

/* A thread is begun in the time of some thousand corners. */
enum { CORNERS_WORTH_A_WORKER = 1 << 14 };

void norma_core_share(core_call *call, size_t corners) {
    const size_t worth = 1 + corners / CORNERS_WORTH_A_WORKER;
    call->workers = worth == 1 ? 1 : 0;
    const size_t workers = norma_core_workers(call);
    call->workers = workers < worth ? workers : worth;
}

/* No more than there ever are: products of more could exceed a size_t of 32 bits. */
size_t norma_core_workers(const core_call *call) {
    if (call->workers) return call->workers;
    const size_t wanted =
        call->options.threads == NORMA_ALL_THREADS ? machine_threads() : call->options.threads;
    return !wanted ? 1 : wanted < MOST_WORKERS ? wanted : MOST_WORKERS;
}

size_t norma_core_shares(const core_call *call) {
    enum { LEAST_FOR_JOBS = 8 };
    if (!call->options.parallel_for) return norma_core_workers(call);
    const size_t cores = machine_threads();
    return cores > LEAST_FOR_JOBS ? cores : LEAST_FOR_JOBS;
}

norma_result norma_core_parallel(core_call *call, size_t count, norma_task *task, void *context) {
    const pool c = {call, task, context, count};
    if (call->options.parallel_for) return run_in_callers_jobs(&c);
    const size_t most = count > 1 ? norma_core_workers(call) : 1,
                 workers = most < count ? most : count;
    return workers > 1 ? run_in_threads(&c, workers) : run_in_order(&c);
}

/* ---- elements written a chunk at a time */

typedef struct chunk_work {
    core_write_chunk *write;
    const void *context;
    size_t count, in_chunk;
    core_tally *tallies; /* of each chunk */
} chunk_work;

static void write_chunk(void *context, size_t chunk) {
    const chunk_work *work = context;
    const size_t begin = chunk * work->in_chunk, left = work->count - begin;
    work->write(work->context, begin, left < work->in_chunk ? work->count : begin + work->in_chunk,
        &work->tallies[chunk]);
}

norma_result norma_core_write_chunks(core_call *call, size_t count, size_t in_chunk,
    core_write_chunk *write, const void *context, core_tally *sum) {
    const size_t chunks = count / in_chunk + (count % in_chunk != 0);
    chunk_work work = {
        write, context, count, in_chunk, norma_core_allocate(call, chunks, sizeof *work.tallies)};
    if (!work.tallies) return NORMA_ERROR_MEMORY;
    memset(work.tallies, 0, chunks * sizeof *work.tallies);
    const norma_result result = norma_core_parallel(call, chunks, write_chunk, &work);
    for (size_t i = 0; i < chunks; ++i) norma_core_tally_add(sum, &work.tallies[i]);
    norma_core_release(call, work.tallies, chunks, sizeof *work.tallies);
    return result;
}
