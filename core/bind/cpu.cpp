// neve._cpu: which instruction sets the processor has. Compiled for any processor, unlike the rest of the core.
#include <Python.h>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace {

#if defined(__x86_64__)
// What the levels ask for beyond the names that every compiler knows: CX16 and LAHF (v2); LZCNT, MOVBE and F16C (v3).
struct Rest {
  bool v2 = false, v3 = false;

  Rest() {
    unsigned a = 0, b = 0, c = 0, d = 0, more = 0;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !__get_cpuid(0x80000001, &a, &b, &more, &d)) return;
    const auto has = [](unsigned word, int bit) { return (word >> bit & 1u) != 0; };
    v2 = has(c, 13) && has(more, 0);
    v3 = has(c, 22) && has(c, 29) && has(more, 5);
  }
};
#endif

// The levels of the x86-64 psABI that the processor has, lowest first; none on other processors.
PyObject* levels(PyObject*, PyObject*) {
  PyObject* found = PyList_New(0);
  if (!found) return nullptr;
#if defined(__x86_64__)
  __builtin_cpu_init();
  const Rest rest;
  const bool v2 = rest.v2 && __builtin_cpu_supports("ssse3") && __builtin_cpu_supports("sse4.1") &&
                  __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
  const bool v3 = v2 && rest.v3 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  const bool has[] = {true, v2, v3, v4};
  const char* const names[] = {"x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"};
  for (int k = 0; k < 4; ++k) {
    PyObject* name = has[k] ? PyUnicode_FromString(names[k]) : nullptr;
    if (has[k] && (!name || PyList_Append(found, name) != 0)) {
      Py_XDECREF(name);
      Py_DECREF(found);
      return nullptr;
    }
    Py_XDECREF(name);
  }
#endif
  return found;
}

PyMethodDef methods[] = {
    {"levels", levels, METH_NOARGS,
     "Return the x86-64 levels of this processor, lowest first; an empty list on others."},
    {nullptr, nullptr, 0, nullptr}};
PyModuleDef module = {PyModuleDef_HEAD_INIT,
                      "_cpu",
                      "What the processor can do.",
                      -1,
                      methods,
                      nullptr,
                      nullptr,
                      nullptr,
                      nullptr};

}  // namespace

PyMODINIT_FUNC PyInit__cpu() { return PyModule_Create(&module); }
