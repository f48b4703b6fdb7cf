// For test_near_solids.py: what is told of a mesh near a patch by a few comparisons, and where the mesh is.
#include "cpu/near.hpp"
#include "geometry/sdf_build.hpp"
#include "math/bspline.hpp"

namespace neve::probe {

using T = double;

// An octahedron, whose corners are `size` from the middle.
inline SdfGrid octahedron(double size, double spacing) {
  std::vector<Point> corners;
  for (int k = 0; k < 3; ++k) {
    for (double side : {-size, size}) {
      Point p{};
      p[k] = side;
      corners.push_back(p);
    }
  }
  std::vector<std::array<std::int32_t, 3>> faces;
  for (int i = 0; i < 8; ++i) {
    const std::int32_t x = i >> 2 & 1, y = 2 + (i >> 1 & 1), z = 4 + (i & 1);
    const bool outward = (x + (y - 2) + (z - 4)) % 2 == 1;
    faces.push_back(outward ? std::array<std::int32_t, 3>{x, y, z} : std::array<std::int32_t, 3>{x, z, y});
  }
  return SdfBuilder(TriangleMesh(corners, faces), spacing, 4 * spacing, 0).build();
}

struct World {
  SdfGrid grid;
  SdfView view;
  Model<T> model;

  World(double size, double dx, const double* velocity) : grid(octahedron(size, dx / 2)), view(grid.view()) {
    model.dx = dx;
    Solid<T> solid{};
    solid.kind = Shape::mesh, solid.mesh = &view;
    solid.rotation = identity<T>();
    solid.velocity = {velocity[0], velocity[1], velocity[2]};
    model.solids.push_back(solid);
  }
};

}  // namespace neve::probe

extern "C" {
// Of n points x that move along `path`, in the tile of the home at `block`: phi of the mesh; whether they may be within `reach`
// of it; whether they stay away in a step of dt. Returns how many solids the home keeps.
int near_home(double size, double dx, const double* velocity, const int* block, double dt, double reach,
              int n, const double* x, const double* path, double* phi, int* may, int* away) {
  using namespace neve;
  const probe::World world(size, dx, velocity);
  const SolidBalls<double> balls(world.model);
  const auto near =
      solids_near_home<double, Quadratic>(world.model, balls, {block[0], block[1], block[2]}, dt);
  const Vec3<double> first = first_node(dx, {block[0], block[1], block[2]});
  for (int p = 0; p < n; ++p) {
    const Vec3<double> at{x[3 * p], x[3 * p + 1], x[3 * p + 2]},
        moves{path[3 * p], path[3 * p + 1], path[3 * p + 2]};
    phi[p] = surface(world.model.solids[0], at, true).phi;
    may[p] = !near.empty() && may_reach(near[0], at - first, reach, true);
    away[p] = near.empty() || stays_away(near[0], at - first, moves, true);
  }
  return static_cast<int>(near.size());
}
}
