// The yardsticks of measure.py: a memcpy and a plain loop that moves the bytes of an encode or a decode and
// computes next to nothing, both split over threads that are started for the call.
#include <pthread.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define MAX_THREADS 64

typedef struct {
    const char *in;
    char *out;
    size_t count;
    void (*run)(const void *in, void *out, size_t count);
} job;

static void *start(void *argument) {
    job *j = argument;
    j->run(j->in, j->out, j->count);
    return NULL;
}

static void split(void (*run)(const void *, void *, size_t), size_t in_size, size_t out_size, const void *in,
                  void *out, size_t count, int threads) {
    if (threads > MAX_THREADS) threads = MAX_THREADS;
    if (threads < 1) threads = 1;
    job jobs[MAX_THREADS];
    pthread_t handles[MAX_THREADS];
    int started[MAX_THREADS];
    for (int t = 0; t < threads; t++) {
        size_t from = count * t / threads, to = count * (t + 1) / threads;
        jobs[t] = (job){(const char *)in + from * in_size, (char *)out + from * out_size, to - from, run};
        started[t] = t > 0 && pthread_create(&handles[t], NULL, start, &jobs[t]) == 0;
    }
    for (int t = 0; t < threads; t++) {
        if (started[t]) pthread_join(handles[t], NULL);
        else start(&jobs[t]);
    }
}

static void copy_bytes(const void *in, void *out, size_t count) { memcpy(out, in, count); }

void copy(const void *in, void *out, size_t bytes, int threads) {
    split(copy_bytes, 1, 1, in, out, bytes, threads);
}

// One function for each pair of widths. Every input is read and every output depends on one.
#define MOVE_3_2(T, NAME)                                                      \
    static void NAME##_part(const void *in, void *out, size_t count) {         \
        const T *restrict a = in;                                              \
        T *restrict b = out;                                                   \
        for (size_t i = 0; i < count; i++) {                                   \
            b[2 * i] = a[3 * i] + a[3 * i + 2];                                \
            b[2 * i + 1] = a[3 * i + 1] + a[3 * i + 2];                        \
        }                                                                      \
    }
#define MOVE_2_3(T, NAME)                                                      \
    static void NAME##_part(const void *in, void *out, size_t count) {         \
        const T *restrict a = in;                                              \
        T *restrict b = out;                                                   \
        for (size_t i = 0; i < count; i++) {                                   \
            b[3 * i] = a[2 * i];                                               \
            b[3 * i + 1] = a[2 * i + 1];                                       \
            b[3 * i + 2] = a[2 * i] + a[2 * i + 1];                            \
        }                                                                      \
    }
#define MOVE_3_3(T, NAME)                                                      \
    static void NAME##_part(const void *in, void *out, size_t count) {         \
        const T *restrict a = in;                                              \
        T *restrict b = out;                                                   \
        for (size_t i = 0; i < count; i++) {                                   \
            b[3 * i] = a[3 * i] + a[3 * i + 2];                                \
            b[3 * i + 1] = a[3 * i + 1];                                       \
            b[3 * i + 2] = a[3 * i + 2];                                       \
        }                                                                      \
    }
#define EXPORT(T, NAME, IN, OUT)                                               \
    void NAME(const void *in, void *out, size_t count, int threads) {          \
        split(NAME##_part, IN * sizeof(T), OUT * sizeof(T), in, out, count, threads); \
    }
#define ALL(T, NAME)                                                           \
    MOVE_3_2(T, NAME##_3_2) EXPORT(T, NAME##_3_2, 3, 2)                        \
    MOVE_2_3(T, NAME##_2_3) EXPORT(T, NAME##_2_3, 2, 3)                        \
    MOVE_3_3(T, NAME##_3_3) EXPORT(T, NAME##_3_3, 3, 3)

ALL(float, move_f32)
ALL(double, move_f64)

// Three floats to one word and back, as packing a direction into 32 bits does.
static void pack_part(const void *in, void *out, size_t count) {
    const uint32_t *restrict a = in;
    uint32_t *restrict b = out;
    for (size_t i = 0; i < count; i++) b[i] = a[3 * i] ^ a[3 * i + 1] ^ a[3 * i + 2];
}

static void unpack_part(const void *in, void *out, size_t count) {
    const uint32_t *restrict a = in;
    uint32_t *restrict b = out;
    for (size_t i = 0; i < count; i++) {
        b[3 * i] = a[i];
        b[3 * i + 1] = a[i] + 1;
        b[3 * i + 2] = a[i] ^ 2;
    }
}

void move_pack(const void *in, void *out, size_t count, int threads) {
    split(pack_part, 12, 4, in, out, count, threads);
}

void move_unpack(const void *in, void *out, size_t count, int threads) {
    split(unpack_part, 4, 12, in, out, count, threads);
}
