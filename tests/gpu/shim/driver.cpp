// A stand-in for the driver library of CUDA: the functions that neve.cuda.driver calls, with memory of the processor, and the
// kernels run by cuda.hpp. What cuModuleLoadData loads is not machine code but the name of a library of choice.cpp.
#include <dlfcn.h>

#include <cstring>
#include <string>

#include "module.hpp"
#include "streams.hpp"

namespace {

using namespace shim;
constexpr int invalid = 1, no_memory = 2, no_device = 101, no_context = 201, not_found = 500, launch_failure = 719;
unsigned order = 0, version = 13010, devices = 1;
std::string failing;
int failed = 0;
int contexts[most_devices];         // their places say which GPU is meant
thread_local int device_here = -1;  // each thread has to say which GPU it means
int state() { return device_here >= 0 ? failed : no_context; }
Stream& usual_here() {
  Stream& stream = usual[std::max(device_here, 0)];
  stream.device = std::max(device_here, 0), stream.is_usual = true;
  return stream;
}
Stream& stream_of(void* stream) { return stream ? *static_cast<Stream*>(stream) : usual_here(); }

std::size_t graphs = 0, graph_launches = 0;
}  // namespace

extern "C" {
// What tests set and ask.
void shim_set(std::size_t bytes, unsigned threads_order, unsigned driver_version, unsigned device_count, int which_late) {
  finish_all();
  memory.limit = bytes, order = threads_order, version = driver_version, devices = device_count;
  late = Late(which_late);
}
void shim_fail(const char* kernel) { failing = kernel, failed = 0; }
std::size_t shim_graphs(bool launches) { return launches ? graph_launches : graphs; }
std::size_t shim_lanes() { return lanes.size(); }
std::size_t shim_used(int device, bool most) { return most ? memory.used_most[device] : memory.used[device]; }
// Whether a kernel has written beyond the end of an allocation.
bool shim_overrun() { return memory.overrun(); }

int cuInit(unsigned) { return devices ? 0 : 100; }
int cuDriverGetVersion(int* out) { return *out = int(version), 0; }
int cuDeviceGetCount(int* out) { return *out = int(devices), 0; }
int cuDeviceGet(int* out, int number) { return *out = number, number < int(devices) ? 0 : no_device; }
int cuDeviceGetName(char* out, int, int) { return std::strcpy(out, "shim"), 0; }
int cuDeviceTotalMem_v2(std::size_t* out, int) { return *out = memory.limit, 0; }
int cuDeviceGetAttribute(int* out, int what, int) { return *out = what == 75 ? 9 : 0, 0; }
int cuDevicePrimaryCtxRetain(void** out, int number) { return *out = &contexts[number], 0; }
int cuCtxSetCurrent(void* context) {
  device_here = int(static_cast<int*>(context) - contexts);
  return 0;
}
int cuCtxSynchronize() { return finish_all(), state(); }
int cuMemGetInfo_v2(std::size_t* left, std::size_t* all) {
  const std::size_t used = memory.used[std::max(device_here, 0)];
  return *left = memory.limit > used ? memory.limit - used : 0, *all = memory.limit, 0;
}
int cuMemAlloc_v2(unsigned long long* out, std::size_t size) {
  if (device_here < 0) return no_context;
  char* at = memory.allocate(device_here, size);
  *out = reinterpret_cast<unsigned long long>(at);
  return at ? 0 : no_memory;
}
int cuMemFree_v2(unsigned long long address) {
  finish_all();
  memory.free(reinterpret_cast<char*>(address));
  return 0;
}
int cuMemcpyHtoD_v2(unsigned long long to, const void* from, std::size_t n) {
  if (!memory.is_of(device_here, reinterpret_cast<void*>(to))) return invalid;
  usual_here().add([=] { std::memcpy(reinterpret_cast<void*>(to), from, n); });
  return usual_here().finish(), state();
}
int cuMemcpyDtoH_v2(void* to, unsigned long long from, std::size_t n) {
  if (!memory.is_of(device_here, reinterpret_cast<void*>(from))) return invalid;
  usual_here().add([=] { std::memcpy(to, reinterpret_cast<const void*>(from), n); });
  return usual_here().finish(), state();
}
int cuMemcpyDtoD_v2(unsigned long long to, unsigned long long from, std::size_t n) {
  const void *first = reinterpret_cast<void*>(to), *second = reinterpret_cast<void*>(from);
  if (!memory.is_of(device_here, first) || !memory.is_of(device_here, second)) return invalid;
  usual_here().add([=] { std::memcpy(reinterpret_cast<void*>(to), second, n); });
  return state();
}
int cuMemcpyDtoDAsync_v2(unsigned long long to, unsigned long long from, std::size_t n, void* stream) {
  const void *first = reinterpret_cast<void*>(to), *second = reinterpret_cast<void*>(from);
  if (!memory.is_of(device_here, first) || !memory.is_of(device_here, second)) return invalid;
  stream_of(stream).add([=] { std::memcpy(reinterpret_cast<void*>(to), second, n); });
  return state();
}
int cuDeviceCanAccessPeer(int* out, int, int) { return *out = 1, 0; }
int cuCtxEnablePeerAccess(void*, unsigned) { return 704; }  // it has been before
int cuMemcpyPeerAsync(unsigned long long to, void* there, unsigned long long from, void* here, std::size_t n, void* stream) {
  const auto number = [](void* context) { return int(static_cast<int*>(context) - contexts); };
  if (!memory.is_of(number(there), reinterpret_cast<void*>(to))) return invalid;
  if (!memory.is_of(number(here), reinterpret_cast<void*>(from))) return invalid;
  stream_of(stream).add([=] {
    memory.open_all();
    std::memcpy(reinterpret_cast<void*>(to), reinterpret_cast<const void*>(from), n);
  });
  return state();
}
int cuMemsetD8_v2(unsigned long long to, unsigned char a, std::size_t n) {
  if (!memory.is_of(device_here, reinterpret_cast<void*>(to))) return invalid;
  usual_here().add([=] { std::memset(reinterpret_cast<void*>(to), a, n); });
  return state();
}
int cuModuleLoadData(void** out, const void* image) {
  void* library = dlopen(static_cast<const char*>(image), RTLD_NOW | RTLD_LOCAL);
  if (!library) return 200;
  auto* made = new Module;
  reinterpret_cast<void (*)(Module*)>(dlsym(library, "shim_fill"))(made);
  return *out = made, 0;
}
int cuModuleGetFunction(void** out, void* module, const char* name) {
  Module& all = *static_cast<Module*>(module);
  if (!all.contains(name)) return not_found;
  *out = &all[name];
  return 0;
}
int cuLaunchKernel(void* function, unsigned blocks, unsigned, unsigned, unsigned threads, unsigned, unsigned,
                   unsigned, void* stream, void** parameters, void**) {
  const auto& kernel = *static_cast<Function*>(function);
  if (threads > kernel.threads || blocks == 0) return invalid;
  const char* bytes = static_cast<const char*>(parameters[0]);
  Launch launch{function, blocks, threads, std::vector<char>(bytes, bytes + kernel.step_bytes)};  // as they are now
  Stream& on = stream_of(stream);
  if (on.captures) return on.graph.push_back(std::move(launch)), 0;
  on.add([launch = std::move(launch)] {
    const auto& kernel = *static_cast<const Function*>(launch.function);
    if (kernel.name == failing) failed = launch_failure;
    if (failed == 0) kernel.launch(launch.step.data(), launch.blocks, launch.threads, order);
  });
  return 0;  // as a device, which fails later
}
int cuStreamCreate(void** out, unsigned) {
  auto* made = new Stream;
  made->device = device_here;
  lanes.push_back(made);
  return *out = made, 0;
}
int cuStreamDestroy_v2(void* stream) {
  finish_all();
  std::erase(lanes, static_cast<Stream*>(stream));
  return delete static_cast<Stream*>(stream), 0;
}
int cuStreamBeginCapture_v2(void* stream, int) { return static_cast<Stream*>(stream)->captures = true, 0; }
int cuStreamEndCapture(void* stream, void** out) {
  return static_cast<Stream*>(stream)->captures = false, *out = new Graph(static_cast<Stream*>(stream)->graph), 0;
}
int cuGraphInstantiateWithFlags(void** out, void* graph, unsigned long long) {
  return *out = new Graph(*static_cast<Graph*>(graph)), ++graphs, 0;
}
int cuGraphDestroy(void* graph) { return delete static_cast<Graph*>(graph), 0; }
int cuGraphExecDestroy(void* graph) { return delete static_cast<Graph*>(graph), --graphs, 0; }
int cuGraphLaunch(void* graph, void*) {
  ++graph_launches;
  for (Launch& launch : *static_cast<Graph*>(graph)) {
    void* parameters[] = {launch.step.data()};
    cuLaunchKernel(launch.function, launch.blocks, 1, 1, launch.threads, 1, 1, 0, nullptr, parameters, nullptr);
  }
  return 0;
}
int cuEventCreate(void** out, unsigned) { return *out = new Event, 0; }
int cuEventDestroy_v2(void* event) { return delete static_cast<Event*>(event), 0; }
int cuEventRecord(void* event, void* stream) {
  return *static_cast<Event*>(event) = {&stream_of(stream), stream_of(stream).issued}, 0;
}
int cuStreamWaitEvent(void* stream, void* event, unsigned) {
  const Event mark = *static_cast<Event*>(event);
  Stream& on = stream_of(stream);
  on.add([mark, device = on.device] {
    if (mark.stream) mark.stream->run(mark.after);
    memory.open(device);
  });
  return 0;
}
int cuEventSynchronize(void* event) {
  const Event& mark = *static_cast<Event*>(event);
  return mark.stream->run(mark.after), failed;
}
int cuEventElapsedTime(float* out, void*, void*) { return *out = 0, 0; }
int cuGetErrorName(int code, const char** out) {
  *out = code == no_memory        ? "CUDA_ERROR_OUT_OF_MEMORY"
         : code == launch_failure ? "CUDA_ERROR_LAUNCH_FAILED"
                                  : "CUDA_ERROR";
  return 0;
}
}
