// A model as a GPU needs it. In a unit of its own: what else a unit holds decides which calls of the step the compiler inlines.
#pragma once

#include <nanobind/nanobind.h>

#include "mpm/model.hpp"

namespace neve::bind {

template <class T>
void bind_device(nanobind::module_& m, nanobind::class_<Model<T>>& c);

}  // namespace neve::bind
