/* Embree's single-ray walk over what `cargo bench --bench bounces -- FOLDER` wrote:
     cc -O3 -march=native benches/embree.c -lembree3 -lpthread -lm -o embree && ./embree 2 FOLDER/NAME.rays...
   The first argument is the number of threads. Its walk is watertight (RTC_SCENE_FLAG_ROBUST), as ours is; -DFAST makes it the faster one that is not. Prints rays a second and a processor second of tracing alone, and how many distances differ. */
#include <embree3/rtcore.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <xmmintrin.h>

enum { ROUNDS = 5, REPEATS = 4 };

struct work {
    RTCScene scene;
    const float *rays;
    size_t first, end, differ;
    double cpu;
};

static double now(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static void *trace(void *argument) {
    struct work *w = argument;
    _mm_setcsr(_mm_getcsr() | 0x8040); /* denormals are zero, as Embree's manual advises */
    double start = now(CLOCK_THREAD_CPUTIME_ID);
    w->differ = 0;
    for (int k = 0; k < REPEATS; k++)
        for (size_t i = w->first; i < w->end; i++) {
            const float *r = w->rays + 7 * i;
            struct RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            struct RTCRayHit q = {0};
            q.ray.org_x = r[0], q.ray.org_y = r[1], q.ray.org_z = r[2];
            q.ray.dir_x = r[3], q.ray.dir_y = r[4], q.ray.dir_z = r[5];
            q.ray.tfar = INFINITY;
            q.ray.mask = -1;
            q.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(w->scene, &context, &q);
            float t = q.hit.geomID == RTC_INVALID_GEOMETRY_ID ? -1 : q.ray.tfar;
            w->differ += fabsf(t - r[6]) > 1e-4f * fabsf(r[6]);
        }
    w->cpu = now(CLOCK_THREAD_CPUTIME_ID) - start;
    return NULL;
}

static int ascending(const void *a, const void *b) {
    double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

int main(int argc, char **argv) {
    int threads = argc > 2 ? atoi(argv[1]) : 0;
    if (threads < 1 || threads > 64) return fprintf(stderr, "usage: embree THREADS FILE.rays...\n"), 2;
    RTCDevice device = rtcNewDevice(NULL);
    printf("Embree %ld, %d threads\n", (long)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION), threads);
    printf("| file | built in s | Mrays/s | Mrays a processor second | differ |\n|---|---|---|---|---|\n");
    for (int file = 2; file < argc; file++) {
        FILE *in = fopen(argv[file], "rb");
        unsigned counts[2];
        if (!in || fread(counts, 4, 2, in) != 2) return fprintf(stderr, "%s cannot be read\n", argv[file]), 1;
        float *rays = malloc(28 * (size_t)counts[1]);
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        float *corners = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * (size_t)counts[0]);
        unsigned *index = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, counts[0]);
        for (size_t i = 0; i < 3 * (size_t)counts[0]; i++) index[i] = i;
        if (fread(corners, 36, counts[0], in) != counts[0] || fread(rays, 28, counts[1], in) != counts[1])
            return fprintf(stderr, "%s is cut short\n", argv[file]), 1;
        fclose(in);
        double start = now(CLOCK_MONOTONIC);
        rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
        rtcCommitGeometry(mesh);
        RTCScene scene = rtcNewScene(device);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
#ifndef FAST
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
#endif
        rtcAttachGeometry(scene, mesh);
        rtcCommitScene(scene);
        double built = now(CLOCK_MONOTONIC) - start, wall[ROUNDS], cpu[ROUNDS];
        size_t differ = 0;
        for (int round = 0; round < ROUNDS; round++) {
            pthread_t thread[64];
            struct work work[64];
            start = now(CLOCK_MONOTONIC);
            for (int k = 0; k < threads; k++) {
                work[k] = (struct work){scene, rays, counts[1] * (size_t)k / threads, counts[1] * (size_t)(k + 1) / threads, 0, 0};
                pthread_create(&thread[k], NULL, trace, &work[k]);
            }
            cpu[round] = differ = 0;
            for (int k = 0; k < threads; k++) {
                pthread_join(thread[k], NULL);
                cpu[round] += work[k].cpu;
                differ += work[k].differ / REPEATS;
            }
            wall[round] = now(CLOCK_MONOTONIC) - start;
        }
        qsort(wall, ROUNDS, sizeof *wall, ascending);
        qsort(cpu, ROUNDS, sizeof *cpu, ascending);
        double million = 1e-6 * REPEATS * counts[1];
        printf("| %s | %.2f | %.2f | %.3f | %zu of %u |\n", argv[file], built, million / wall[ROUNDS / 2], million / cpu[ROUNDS / 2], differ, counts[1]);
        rtcReleaseScene(scene);
        rtcReleaseGeometry(mesh);
        free(rays);
    }
    rtcReleaseDevice(device);
    return 0;
}
