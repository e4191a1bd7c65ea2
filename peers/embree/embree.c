// Embree's side of the comparison with Glanz; compare.py runs it and describes the comparison.
//
// Reads the mesh and the rays that glanz.rs has written into the given folder, then answers each line SET QUERY THREADS with
// wall-clock nanoseconds, processor nanoseconds, number of rays, number of hits and sum of the ray parameters. Queries: closest;
// any; picture (closest, with the sum of the cosines between interpolated normal and ray; needs a file of normals); dump
// (closest, with the ray parameters written to the file t, -1 for a miss). mesh build THREADS builds the hierarchy again and
// returns the number of triangles, 0 and bytes of memory, buffers included, in place of rays, hits and sum.
#include <embree3/rtcore.h>
#include <math.h>
#include <pmmintrin.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
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

// Memory of Embree, bytes.
static ssize_t memory;

static bool count_memory(void *unused, ssize_t bytes, bool post) {
  (void)unused, (void)post;
  __atomic_fetch_add(&memory, bytes, __ATOMIC_RELAXED);
  return true;
}

typedef struct {
  unsigned vertices, triangles;
  float *positions, *normals;
  unsigned *indices;
} Mesh;

static void *allocate(size_t size, size_t count) {
  void *place = malloc(size * count);
  if (!place) fail("no memory");
  return place;
}

static Mesh read_mesh(const char *folder, int with_normals) {
  Mesh mesh = {0, 0, NULL, NULL, NULL};
  FILE *file = open_file(folder, "mesh");
  get(&mesh.vertices, 4, 1, file);
  get(&mesh.triangles, 4, 1, file);
  get(mesh.positions = allocate(12, mesh.vertices), 12, mesh.vertices, file);
  get(mesh.indices = allocate(12, mesh.triangles), 12, mesh.triangles, file);
  fclose(file);
  if (with_normals) {
    file = open_file(folder, "normals");
    get(mesh.normals = allocate(12, mesh.vertices), 12, mesh.vertices, file);
    fclose(file);
  }
  return mesh;
}

static RTCScene build(RTCDevice device, const Mesh *mesh, int robust, double *clock, double *processors) {
  RTCScene scene = rtcNewScene(device);
  if (robust) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh->vertices), mesh->positions,
         12ul * mesh->vertices);
  memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh->triangles), mesh->indices,
         12ul * mesh->triangles);
  double start = seconds(CLOCK_MONOTONIC), before = seconds(CLOCK_PROCESS_CPUTIME_ID);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  *clock = seconds(CLOCK_MONOTONIC) - start;
  *processors = seconds(CLOCK_PROCESS_CPUTIME_ID) - before;
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("cannot build the scene");
  return scene;
}

// From CLOSEST_16 on they take packets of 16 rays, from CLOSEST_16_COHERENT on with the flag for coherent ones.
typedef enum {
  CLOSEST, ANY, PICTURE, DUMP, CLOSEST_16, ANY_16, CLOSEST_16_COHERENT, ANY_16_COHERENT, PICTURE_16_COHERENT
} Query;

typedef struct {
  RTCScene scene;
  const Mesh *mesh;
  const float *rays;
  unsigned count;
  Query query;
  // Grey levels or ray parameters, one per ray.
  float *image;
  unsigned long hits;
  double sum, time;
} Job;

// The cosine between the direction and the normal, interpolated with the weights u and v.
static float grey(const Mesh *mesh, unsigned triangle, float u, float v, const float *direction) {
  const unsigned *corners = mesh->indices + 3ul * triangle;
  const float *a = mesh->normals + 3ul * corners[0], *b = mesh->normals + 3ul * corners[1], *c = mesh->normals + 3ul * corners[2];
  float w = 1 - u - v;
  float x = w * a[0] + u * b[0] + v * c[0], y = w * a[1] + u * b[1] + v * c[1], z = w * a[2] + u * b[2] + v * c[2];
  return fabsf(x * direction[0] + y * direction[1] + z * direction[2]) / sqrtf(x * x + y * y + z * z);
}

// Rays 16 at a time.
static void work_in_packets(Job *job, struct RTCIntersectContext *context) {
  int any = job->query == ANY_16 || job->query == ANY_16_COHERENT;
  if (job->query >= CLOSEST_16_COHERENT) context->flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (unsigned first = 0; first < job->count; first += 16) {
    __attribute__((aligned(64))) int valid[16];
    __attribute__((aligned(64))) struct RTCRayHit16 q;
    for (unsigned k = 0; k < 16; k++) {
      valid[k] = first + k < job->count ? -1 : 0;
      const float *r = job->rays + 6ul * (valid[k] ? first + k : first);
      q.ray.org_x[k] = r[0], q.ray.org_y[k] = r[1], q.ray.org_z[k] = r[2];
      q.ray.dir_x[k] = r[3], q.ray.dir_y[k] = r[4], q.ray.dir_z[k] = r[5];
      q.ray.tnear[k] = 0, q.ray.tfar[k] = INFINITY, q.ray.time[k] = 0;
      q.ray.mask[k] = -1, q.ray.id[k] = 0, q.ray.flags[k] = 0;
      q.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID, q.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    if (any) {
      rtcOccluded16(valid, job->scene, context, &q.ray);
    } else {
      rtcIntersect16(valid, job->scene, context, &q);
    }
    for (unsigned k = 0; k < 16; k++) {
      if (!valid[k]) continue;
      int hit = any ? q.ray.tfar[k] < 0 : q.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
      job->hits += hit;
      if (job->query == PICTURE_16_COHERENT) {
        const float *direction = job->rays + 6ul * (first + k) + 3;
        float level = hit ? grey(job->mesh, q.hit.primID[k], q.hit.u[k], q.hit.v[k], direction) : 0;
        job->sum += job->image[first + k] = level;
      } else if (hit && !any) {
        job->sum += q.ray.tfar[k];
      }
    }
  }
}

static void *work(void *argument) {
  Job *job = argument;
  double start = seconds(CLOCK_THREAD_CPUTIME_ID);
  // Recommended by Embree's manual.
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  unsigned long hits = 0;
  double sum = 0;
  if (job->query >= CLOSEST_16) {
    work_in_packets(job, &context);
    job->time = seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    return NULL;
  }
  for (unsigned i = 0; i < job->count; i++) {
    const float *r = job->rays + 6ul * i;
    struct RTCRayHit q;
    q.ray.org_x = r[0], q.ray.org_y = r[1], q.ray.org_z = r[2];
    q.ray.dir_x = r[3], q.ray.dir_y = r[4], q.ray.dir_z = r[5];
    q.ray.tnear = 0, q.ray.tfar = INFINITY, q.ray.time = 0, q.ray.mask = -1, q.ray.id = 0, q.ray.flags = 0;
    q.hit.geomID = RTC_INVALID_GEOMETRY_ID, q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    if (job->query == ANY) {
      rtcOccluded1(job->scene, &context, &q.ray);
      hits += q.ray.tfar < 0;
    } else {
      rtcIntersect1(job->scene, &context, &q);
      int hit = q.hit.geomID != RTC_INVALID_GEOMETRY_ID;
      hits += hit;
      if (job->query == CLOSEST) {
        if (hit) sum += q.ray.tfar;
      } else if (job->query == PICTURE) {
        sum += job->image[i] = hit ? grey(job->mesh, q.hit.primID, q.hit.u, q.hit.v, r + 3) : 0;
      } else {
        job->image[i] = hit ? q.ray.tfar : -1;
      }
    }
  }
  job->hits = hits;
  job->sum = sum;
  job->time = seconds(CLOCK_THREAD_CPUTIME_ID) - start;
  return NULL;
}

static Query query_named(const char *name) {
  const char *names[] = {"closest", "any", "picture", "dump", "closest16", "any16", "closest16coherent", "any16coherent",
                         "picture16coherent"};
  for (int i = 0; i < 9; i++)
    if (!strcmp(names[i], name)) return i;
  fail("no such query");
  return CLOSEST;
}

static void answer(RTCScene scene, const Mesh *mesh, const Set *set, const char *folder, Query query, int threads) {
  pthread_t workers[64];
  Job jobs[64];
  int is_picture = query == PICTURE || query == PICTURE_16_COHERENT;
  float *image = is_picture || query == DUMP ? allocate(4, set->count) : NULL;
  if (is_picture && !mesh->normals) fail("a picture needs normals");
  unsigned part = (set->count + threads - 1) / threads;
  double start = seconds(CLOCK_MONOTONIC);
  for (int i = 0; i < threads; i++) {
    unsigned first = part * i < set->count ? part * i : set->count;
    unsigned rest = set->count - first;
    const float *rays = set->rays + 6ul * first;
    jobs[i] = (Job){scene, mesh, rays, rest < part ? rest : part, query, image ? image + first : NULL, 0, 0, 0};
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
  double clock = seconds(CLOCK_MONOTONIC) - start;
  if (query == DUMP) {
    char path[4096];
    snprintf(path, sizeof path, "%s/t", folder);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(image, 4, set->count, file) != set->count || fclose(file)) fail("cannot write the ray parameters");
  }
  free(image);
  printf("%.0f %.0f %u %lu %.9g\n", 1e9 * clock, 1e9 * time, set->count, hits, sum);
}

int main(int count, char **arguments) {
  if (count != 3 && count < 5) fail("usage: embree FOLDER fast|robust [THREADS TO BUILD, SETS OF RAYS ...]");
  const char *folder = arguments[1];
  int robust = !strcmp(arguments[2], "robust");
  char config[64];
  snprintf(config, sizeof config, "threads=%d", count > 3 ? atoi(arguments[3]) : 2);
  RTCDevice device = rtcNewDevice(config);
  rtcSetDeviceMemoryMonitorFunction(device, count_memory, NULL);
  // There are normals only if the sets of rays are given.
  Mesh mesh = read_mesh(folder, count > 3);
  double built, processors;
  RTCScene scene = build(device, &mesh, robust, &built, &processors);
  char *usual[] = {"coherent", "random", "bounced"};
  char **names = count > 3 ? arguments + 4 : usual;
  int kinds = count > 3 ? count - 4 : 3;
  Set *sets = allocate(sizeof *sets, kinds);
  for (int i = 0; i < kinds; i++) sets[i] = read_set(folder, names[i]);
  printf("%g s Embree " RTC_VERSION_STRING " %s\n", built, arguments[2]);
  fflush(stdout);
  char name[32], query[32];
  int threads;
  while (scanf("%31s %31s %d", name, query, &threads) == 3) {
    if (!strcmp(query, "build")) {
      rtcReleaseScene(scene);
      scene = build(device, &mesh, robust, &built, &processors);
      printf("%.0f %.0f %u 0 %zd\n", 1e9 * built, 1e9 * processors, mesh.triangles, memory);
    } else {
      Set *set = NULL;
      for (int i = 0; i < kinds; i++)
        if (!strcmp(sets[i].name, name)) set = &sets[i];
      if (!set || threads < 1 || threads > 64) fail("no such set of rays, or too many threads");
      answer(scene, &mesh, set, folder, query_named(query), threads);
    }
    fflush(stdout);
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return 0;
}
