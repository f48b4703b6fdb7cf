// Lane packs and all that is done with them.
#pragma once

#include "math/functions.hpp"
#include "math/pack.hpp"
#include "math/rows.hpp"
