// A stand-in for the driver library of CUDA: the functions that neve.cuda.driver calls, with memory of the processor, and the
// kernels run by cuda.hpp. What cuModuleLoadData loads is not machine code but the words of the choice.
#include <cstring>
#include <map>
#include <string>

#include "cuda.hpp"
#include "cuda/kernels.hpp"

namespace {

constexpr int no_memory = 2, no_context = 201, not_found = 500, launch_failure = 719;
constexpr std::size_t guard = 64;
std::map<char*, std::size_t> allocated;
std::size_t limit = std::size_t(1) << 33, used = 0, used_most = 0;
unsigned order = 0, version = 13010, devices = 1;
std::string failing;
int failed = 0;
thread_local bool has_context = false;  // each thread has to say which GPU it means
int state() { return has_context ? failed : no_context; }

using Entry = std::function<void(const void*)>;
struct Function {
  std::string name;
  unsigned threads;
  std::size_t step_bytes;
  Entry run;
};
struct Launch {
  void* function;
  unsigned blocks, threads;
  std::vector<char> step;
};
using Graph = std::vector<Launch>;  // also a stream that captures one
std::size_t graphs = 0, graph_launches = 0;
using Module = std::map<std::string, Function>;

template <class C>
Module module_of() {
  using namespace neve::cuda;
  using T = typename C::T;
  Module out;
#define SHIM_ENTRY(name, threads, function)       \
  out["neve_" #name] = {#name, unsigned(threads), sizeof(Step<T>), \
                        [](const void* step) { function(*static_cast<const Step<T>*>(step)); }};
  NEVE_KERNELS(SHIM_ENTRY)
  return out;
}

#define SHIM_CHOICE(...) {#__VA_ARGS__, &module_of<neve::cuda::Choice<__VA_ARGS__>>},
const std::map<std::string, Module (*)()> choices = {
#include "choices.inc"
};

}  // namespace

extern "C" {
// What tests set and ask.
void shim_set(std::size_t bytes, unsigned threads_order, unsigned driver_version, unsigned device_count) {
  limit = bytes, order = threads_order, version = driver_version, devices = device_count;
}
void shim_fail(const char* kernel) { failing = kernel, failed = 0; }
std::size_t shim_graphs(bool launches) { return launches ? graph_launches : graphs; }
std::size_t shim_used(bool most) { return most ? used_most : used; }
// Whether a kernel has written beyond the end of an allocation.
bool shim_overrun() {
  for (const auto& [at, size] : allocated) {
    for (std::size_t k = 0; k < guard; ++k) {
      if (at[size + k] != char(0xa5)) return true;
    }
  }
  return false;
}

int cuInit(unsigned) { return devices ? 0 : 100; }
int cuDriverGetVersion(int* out) { return *out = int(version), 0; }
int cuDeviceGetCount(int* out) { return *out = int(devices), 0; }
int cuDeviceGet(int* out, int) { return *out = 0, 0; }
int cuDeviceGetName(char* out, int, int) { return std::strcpy(out, "shim"), 0; }
int cuDeviceTotalMem_v2(std::size_t* out, int) { return *out = limit, 0; }
int cuDeviceGetAttribute(int* out, int what, int) { return *out = what == 75 ? 9 : 0, 0; }
int cuDevicePrimaryCtxRetain(void** out, int) { return *out = &allocated, 0; }
int cuCtxSetCurrent(void*) {
  has_context = true;
  return 0;
}
int cuCtxSynchronize() { return state(); }
int cuMemGetInfo_v2(std::size_t* left, std::size_t* all) { return *left = limit > used ? limit - used : 0, *all = limit, 0; }
int cuMemAlloc_v2(unsigned long long* out, std::size_t size) {
  if (!has_context) return no_context;
  if (used + size > limit) return no_memory;
  char* at = static_cast<char*>(std::aligned_alloc(256, (size + guard + 255) / 256 * 256));
  std::memset(at, 0xff, size);  // NaN: what is read before it is written shows
  std::memset(at + size, 0xa5, guard);
  allocated[at] = size, used += size, used_most = std::max(used, used_most);
  *out = reinterpret_cast<unsigned long long>(at);
  return 0;
}
int cuMemFree_v2(unsigned long long address) {
  char* at = reinterpret_cast<char*>(address);
  used -= allocated.at(at), allocated.erase(at), std::free(at);
  return 0;
}
int cuMemcpyHtoD_v2(unsigned long long to, const void* from, std::size_t n) {
  return std::memcpy(reinterpret_cast<void*>(to), from, n), state();
}
int cuMemcpyDtoH_v2(void* to, unsigned long long from, std::size_t n) {
  return std::memcpy(to, reinterpret_cast<const void*>(from), n), state();
}
int cuMemsetD8_v2(unsigned long long to, unsigned char a, std::size_t n) {
  return std::memset(reinterpret_cast<void*>(to), a, n), state();
}
int cuModuleLoadData(void** out, const void* image) {
  const auto found = choices.find(static_cast<const char*>(image));
  if (found == choices.end()) return 200;
  *out = new Module(found->second());
  return 0;
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
  if (threads > kernel.threads || blocks == 0) return 1;
  if (stream) {  // to be captured: the parameters as they are now
    const char* bytes = static_cast<const char*>(parameters[0]);
    static_cast<Graph*>(stream)->push_back(
        {function, blocks, threads, std::vector<char>(bytes, bytes + kernel.step_bytes)});
    return 0;
  }
  if (kernel.name == failing) failed = launch_failure;
  if (failed == 0) shim::launch([&] { kernel.run(parameters[0]); }, blocks, threads, order);
  return 0;  // as a device, which fails later
}
int cuStreamCreate(void** out, unsigned) { return *out = new Graph, 0; }
int cuStreamDestroy_v2(void* stream) { return delete static_cast<Graph*>(stream), 0; }
int cuStreamBeginCapture_v2(void* stream, int) { return static_cast<Graph*>(stream)->clear(), 0; }
int cuStreamEndCapture(void* stream, void** out) { return *out = new Graph(*static_cast<Graph*>(stream)), 0; }
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
int cuEventCreate(void** out, unsigned) { return *out = new double(0), 0; }
int cuEventRecord(void*, void*) { return 0; }
int cuEventSynchronize(void*) { return failed; }
int cuEventElapsedTime(float* out, void*, void*) { return *out = 0, 0; }
int cuGetErrorName(int code, const char** out) {
  *out = code == no_memory        ? "CUDA_ERROR_OUT_OF_MEMORY"
         : code == launch_failure ? "CUDA_ERROR_LAUNCH_FAILED"
                                  : "CUDA_ERROR";
  return 0;
}
}
