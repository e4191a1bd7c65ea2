// The side of Embree in the comparison with Glanz; compare.py runs it and explains.
//
// Reads the mesh and the rays that glanz.rs wrote into the folder given, then waits for lines SET QUERY THREADS and
// answers each with nanoseconds by the clock, nanoseconds of the processors, number of rays, number of hits and sum of
// the ray parameters.
#include <embree3/rtcore.h>
#include <math.h>
#include <pmmintrin.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <xmmintrin.h>

static void fail(const char *what) {
  fprintf(stderr, "embree: %s\n", what);
  exit(1);
}

static double seconds(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static FILE *open_file(const char *folder, const char *name) {
  char path[4096];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "rb");
  if (!file) fail(path);
  return file;
}

static void get(void *to, size_t size, size_t count, FILE *file) {
  if (fread(to, size, count, file) != count) fail("file too short");
}

typedef struct {
  char name[32];
  unsigned count;
  float *rays;
} Set;

static Set read_set(const char *folder, const char *name) {
  Set set = {{0}, 0, NULL};
  FILE *file = open_file(folder, name);
  strncpy(set.name, name, sizeof set.name - 1);
  get(&set.count, 4, 1, file);
  set.rays = malloc(24ul * set.count);
  if (!set.rays) fail("no memory");
  get(set.rays, 24, set.count, file);
  fclose(file);
  return set;
}

typedef struct {
  RTCScene scene;
  const float *rays;
  unsigned count;
  int any;
  unsigned long hits;
  double sum, time;
} Job;

static void *work(void *argument) {
  Job *job = argument;
  double start = seconds(CLOCK_THREAD_CPUTIME_ID);
  // As Embree's manual advises.
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  unsigned long hits = 0;
  double sum = 0;
  for (unsigned i = 0; i < job->count; i++) {
    const float *r = job->rays + 6ul * i;
    struct RTCRayHit q;
    q.ray.org_x = r[0], q.ray.org_y = r[1], q.ray.org_z = r[2];
    q.ray.dir_x = r[3], q.ray.dir_y = r[4], q.ray.dir_z = r[5];
    q.ray.tnear = 0, q.ray.tfar = INFINITY, q.ray.time = 0, q.ray.mask = -1, q.ray.id = 0, q.ray.flags = 0;
    q.hit.geomID = RTC_INVALID_GEOMETRY_ID, q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    if (job->any) {
      rtcOccluded1(job->scene, &context, &q.ray);
      hits += q.ray.tfar < 0;
    } else {
      rtcIntersect1(job->scene, &context, &q);
      if (q.hit.geomID != RTC_INVALID_GEOMETRY_ID) hits++, sum += q.ray.tfar;
    }
  }
  job->hits = hits;
  job->sum = sum;
  job->time = seconds(CLOCK_THREAD_CPUTIME_ID) - start;
  return NULL;
}

int main(int count, char **arguments) {
  if (count != 3) fail("usage: embree FOLDER fast|robust");
  const char *folder = arguments[1];
  unsigned vertices, triangles;
  FILE *file = open_file(folder, "mesh");
  get(&vertices, 4, 1, file);
  get(&triangles, 4, 1, file);
  RTCDevice device = rtcNewDevice("threads=2");
  RTCScene scene = rtcNewScene(device);
  if (!strcmp(arguments[2], "robust")) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  get(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices), 12, vertices, file);
  get(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles), 12, triangles, file);
  fclose(file);
  double start = seconds(CLOCK_MONOTONIC);
  rtcCommitGeometry(mesh);
  rtcAttachGeometry(scene, mesh);
  rtcReleaseGeometry(mesh);
  rtcCommitScene(scene);
  double built = seconds(CLOCK_MONOTONIC) - start;
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("cannot build the scene");
  Set sets[] = {read_set(folder, "coherent"), read_set(folder, "random"), read_set(folder, "bounced")};
  printf("%g s Embree " RTC_VERSION_STRING " %s\n", built, arguments[2]);
  fflush(stdout);
  char name[32], query[32];
  int threads;
  while (scanf("%31s %31s %d", name, query, &threads) == 3) {
    Set *set = NULL;
    for (int i = 0; i < 3; i++)
      if (!strcmp(sets[i].name, name)) set = &sets[i];
    if (!set || threads < 1 || threads > 64) fail("no such set of rays, or too many threads");
    pthread_t workers[64];
    Job jobs[64];
    unsigned part = (set->count + threads - 1) / threads;
    start = seconds(CLOCK_MONOTONIC);
    for (int i = 0; i < threads; i++) {
      unsigned first = part * i < set->count ? part * i : set->count;
      unsigned rest = set->count - first;
      jobs[i] = (Job){scene, set->rays + 6ul * first, rest < part ? rest : part, !strcmp(query, "any"), 0, 0, 0};
      if (pthread_create(&workers[i], NULL, work, &jobs[i])) fail("no thread");
    }
    unsigned long hits = 0;
    double sum = 0, time = 0;
    for (int i = 0; i < threads; i++) {
      pthread_join(workers[i], NULL);
      hits += jobs[i].hits;
      sum += jobs[i].sum;
      time += jobs[i].time;
    }
    printf("%.0f %.0f %u %lu %.9g\n", 1e9 * (seconds(CLOCK_MONOTONIC) - start), 1e9 * time, set->count, hits, sum);
    fflush(stdout);
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return 0;
}
