#include <nanobind/nanobind.h>
namespace nb = nanobind;
NB_MODULE(_look, m) { m.doc() = "Light and draw particles."; }
