// What every kernel is given: where the arrays of particles and nodes lie on the device, and the constants of the step.
//
// The host fills these structs (neve.cuda.layout has the same fields in the same order) and hands them over by value.
#pragma once

#include "constitutive/law.hpp"
#include "coupling/body_response.hpp"
#include "coupling/solid.hpp"
#include "mpm/block_key.hpp"
#include "mpm/step_choice.hpp"
#include "mpm/step_constants.hpp"

namespace neve::cuda {

// Most columns of velocity modes: PolyPIC with 27 modes keeps 23 beyond v and C, and one more is the lift.
inline constexpr int most_mode_columns = 72;

// The columns of mpm/state.hpp. Each has its own address, since sorting exchanges a column for another.
template <class T>
struct Particles {
  T *x[3], *v[3], *C[9], *F_E[9], *tau[6], *J_P, *m, *V0, *stiffness, *strength;
  T* modes[most_mode_columns];
  unsigned short* material;
  unsigned* id;
};

// Four numbers of a node: (m v, m), (v, m), (f, -), ...
template <class T>
struct alignas(16) Quad {
  T x, y, z, w;
};

inline constexpr int block_nodes = 64;
inline constexpr int tile_side = 8, tile_nodes = tile_side * tile_side * tile_side;

// A block that owns particles: the range [begin, begin + count), and the eight blocks of nodes of its tile, index
// 4 dx + 2 dy + dz. Until link_homes() `nodes` holds slots of the table of blocks.
struct Home {
  BlockCoord at;
  unsigned begin, count;
  int nodes[8];
};

// What the nodes of a block do: their velocities from `low` to `high`, but for those that are too light, and the largest
// change of a velocity along one axis.
template <class T>
struct Bounds {
  Vec3<T> low, high;
  T change;
  int finite;
};

template <class T>
struct Nodes {
  Home* homes;
  BlockCoord* at;  // of each block
  Quad<T>*node, *change, *lift;
  Quad<T>*next, *next_force;  // of the step after this one, where g2p2g scatters
  Bounds<T>* bounds;
  const int* some;    // the homes of a launch of p2g; null: all
  const int* ghosts;  // of each block: whether another domain counts what solids do there; null: none
};

// What this device has of a run on several: domain d owns the homes whose coordinate along `axis` is at least
// cuts[d - 1] and below cuts[d].
struct Domain {
  const int* cuts;         // ascending [blocks]
  unsigned* counts;        // of each domain: particles here that belong there
  const unsigned* begins;  // where they begin when the rows are parted by domain
  unsigned axis, number, domains, unused;
};

// Blocks of nodes that several domains have, for one of the others.
enum class Meeting { copy, take, add };
template <class T>
struct Halo {
  const int* blocks;
  Quad<T>* values;  // of their nodes, all of one kind after all of another
  unsigned count;
  int meeting;
};

// Block keys -> numbers 0, 1, ..., in the order in which they came. `capacity` is a power of two.
struct Table {
  BlockKey* keys;  // of each slot, or no_key
  int* value;      // of each slot
  BlockKey* list;  // of each number
  unsigned* count;
  unsigned capacity, shift;  // 2^(64 - shift) = capacity
};
inline constexpr BlockKey no_key = ~BlockKey(0);

// What sorting works with.
struct Sorting {
  Table homes, blocks;
  int* home_of;      // of each particle: first its slot, then its home
  unsigned* place;   // of each particle in its home
  unsigned* order;   // the particle that comes to each place
  BlockKey* key;     // what the particles of a home are ordered by
  const void* from;  // the column to be permuted
  void* to;
  unsigned span, width;  // of a pass over the keys of the homes
};

// The extremes that a stage has found, as ordered() numbers: all are maxima, so that no order of the threads matters.
enum Extreme {
  wave,
  speed,
  fastest,
  rate2,
  compression,
  displacement2,
  less_volume,
  less_ice_room,  // of particles
  node_speed,
  node_difference,
  node_change,  // of nodes
  less_mass,    // of the lightest particle
  extremes
};
struct Results {
  BlockKey most[extremes];
  unsigned not_finite, drifted, full;  // whether; `full`: a table of blocks is to be enlarged
  unsigned offender,
      lost;  // ~ the lowest birth number of a particle that may not move so, or has left; 0: none
  unsigned homes, blocks;
  unsigned waiting;  // blocks of nodes that wait for the velocities of bodies
};

inline constexpr int sum_parts = 4;  // of a sum in a fixed order (grid/sum.hpp)

// Sums over all particles, and what inspect() has seen.
struct Sums {
  BlockKey number[8 * sum_parts];  // 8 of Sum: mass, momentum, kinetic, affine, elastic, potential energy
  BlockKey densest;                // density over that of ice as a float, ~ row; 0: none
  unsigned doubtful, unused;
};

inline constexpr unsigned all_colours = 8;

template <class T>
struct Constants {
  StepConstants<T> step;
  Vec3<T> gravity;
};

// What the snow and the bodies that it moves do to each other.
struct Bodies {
  int* waiting;            // blocks of nodes that may touch one
  const double* velocity;  // six numbers of each, as if they moved so
  void* response;          // a BodyResponse of each, in numbers of Sum
  unsigned count;
  unsigned unused;
};

// What a viewer sees (cuda/picture.hpp).
enum class Shade { none, speed, J_P, density, stress, material };
struct Picture {
  unsigned short* words;  // x, y, z and the value of each particle
  double low[4], per_step[4];
  int shade, unused;
};

// Why no further step is taken without the host.
enum class Halt {
  none,
  finished,  // the time is over
  trial,     // a step might have to be rejected: it must be tried first
  drifted,   // particles have left their homes: sort
  broken,    // a number is not finite
  unusual,   // the step is too short, or shorter than the user's own
};

inline constexpr int most_steps = 64;  // that are taken without the host
struct StepRecord {
  double dt;
  int bound, unused;
};

// What the device needs to choose steps itself, and what it has done (cuda/pace.hpp).
template <class T>
struct Control {
  StepLimits limits;
  ParticleRates rates;                        // of the last step
  double max_displacement, min_volume_ratio;  // likewise, as in Report
  double flip_alpha, flip_damping;            // of the model; damping below 0: none
  double remaining;                           // [s]
  double dt;                                  // of the step under way [s]
  StepRecord record[most_steps];
  int taken, halt, drifted, broken;
  int under_way;  // the step is taken
  int bound;      // of the step under way
  T step_dt;      // as kernels need it
  FlipBlend<T> blend;
  T unused_too;
};

template <class T>
struct Step {
  Particles<T> particles;
  Nodes<T> nodes;
  Sorting sorting;
  const Snow* snows;
  const Solid<T>* solids;
  void* exchanged;  // with each solid: an Exchange, in numbers of Sum
  Results* results;
  Sums* sums;
  Bodies bodies;
  Domain domain;
  Halo<T> halo;
  Picture picture;
  Control<T>* control;  // of steps that are taken without the host; null: the host's constants count
  void* accepted;       // as `exchanged`, of the steps that were taken
  unsigned particle_count, home_count, block_count, solid_count, snow_count;
  int commit;       // g2p: move the particles, not only report
  unsigned colour;  // p2g: of the homes whose turn it is; all_colours: of all
  T lightest;       // mass of the lightest particle [kg]
  Constants<T> constants;
};

}  // namespace neve::cuda
