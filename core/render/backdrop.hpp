// The set in every pixel: which solid or sky is there and how it takes the light. What does not move is
// described once per film, and so is what solids at rest leave of sun and sky; what snow and moving solids leave of
// them is found anew in each frame, on a coarse lattice where it varies slowly.
#pragma once

#include "render/arrival.hpp"
#include "render/puddle.hpp"
#include "render/splat.hpp"

namespace neve::render {

class Backdrop {
 public:
  static constexpr int cell = Samples::cell / Samples::per_axis;  // pixels between the nodes of the lattice

  // leaf: as of SolidSet.
  Backdrop(const Camera& camera, const Light& light, std::uint32_t leaf)
      : camera_(camera),
        light_(light),
        sky_(light),
        size_(std::size_t(camera.width) * std::size_t(camera.height)),
        solid_(size_, Node::unknown),
        point_(size_),
        past_(size_),
        rows_((camera.height - 1) / cell + 2),
        columns_((camera.width - 1) / cell + 2),
        node_(std::size_t(rows_) * std::size_t(columns_)),
        replaced_(node_.size()),
        set_(camera.eye, leaf) {}

  const Sky& sky() const { return sky_; }
  const SolidSet& set() const { return set_; }
  const std::vector<Solid>& solids() const { return set_.solids(); }

  // Forget what solids at rest leave of sun and sky: they are not where they were.
  void forget() {
    known_ = false;
    std::fill(past_.begin(), past_.end(), Past{});
    std::fill(node_.begin(), node_.end(), Node{});
  }

  // Take in the solids of this frame: describe the pixels that show something that was not there before.
  // still, moving: the meshes that rest and the others.
  void place(const std::vector<Solid>& solids, const Raster& still, const Raster& moving) {
    std::fill(replaced_.begin(), replaced_.end(), 0);
    std::vector<std::uint8_t> moved(solids.size(), 1);
    any_ = !known_ || solids.size() != this->solids().size();
    bool plain = any_;  // whether a solid that is no mesh has moved
    for (std::size_t b = 0; b < solids.size(); ++b) {
      moved[b] = b >= this->solids().size() || !(solids[b] == this->solids()[b]);
      any_ = any_ || moved[b];
      plain = plain || (moved[b] && !solids[b].mesh);
    }
    if (!any_) return;
    set_.assign(solids);
    const bool meshes = !still.empty() || !moving.empty();
    if (!known_) {
      still_front_.assign(meshes ? size_ : 0, Front{});
      find_front(still, still_front_);
    }
    known_ = true;
    std::vector<Front> before = std::move(front_);
    front_ = still_front_;
    if (meshes) front_.resize(size_);
    find_front(moving, front_);
    plain = plain || before.size() != front_.size();
#pragma omp parallel for schedule(dynamic, 8)
    for (int r = 0; r < camera_.height; ++r) place_row(r, moved, plain, before);
  }

  // Find sun and sky on the lattice wherever one of the cells around a node shows the set.
  void illuminate(const Density& snow, const Samples& samples) {
    snow_ = &snow;
#pragma omp parallel for schedule(dynamic, 4)
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < columns_; ++j) {
        Node& node = node_[at(i, j)];
        if (any_) node.placed = false;
        node.shown = node_shows(samples, i, j);
        node.changed = node.shown && light_node(node, i, j);
      }
  }

  // Whether the light of a cell of the lattice that shows `solid` in all its samples, or the sky, is interpolated from
  // its nodes, which alone it then depends on.
  bool interpolates(int i, int j, int solid) const {
    if (solid < 0) return true;
    const Corners nodes = corners(i, j);
    return puddles_.empty() && nodes.show(solid) &&
           std::all_of(std::begin(shares_of_light), std::end(shares_of_light),
                       [&](Share s) { return nodes.alike(s, snow_->cell_size()); });
  }
  // Whether such a cell looks as it did in the frame before.
  bool unchanged(int i, int j) const {
    return !replaced_[at(i, j)] && puddles_.empty() && !corners(i, j).changed();
  }

  // Light of the set in pixel (r, c).
  Vec3f light(int r, int c) const {
    const std::size_t p = pixel(r, c);
    const SetPoint& set = point_[p];
    const int solid = solid_[p];
    if (solid < 0) return set.unshadowed;
    return wetted(set, between_nodes(r, c, solid), solid, camera_.through(float(c) + 0.5f, float(r) + 0.5f));
  }

  // Take the water that lies on planes in this frame.
  void wet(std::span<const Puddle> puddles) { puddles_ = puddles; }

  // The solid in the middle of pixel (r, c); -1 is the sky.
  int solid(int r, int c) const { return solid_[pixel(r, c)]; }

  // Light of one solid (or of the sky, -1) in sample (i, j) of pixel (r, c), whose middle shows something else: what a
  // pixel beside it shows of the solid, or the light along the sample's own ray.
  Vec3f light_beside(int solid, int r, int c, int i, int j) const {
    constexpr int n = Samples::per_axis;
    const int down = 2 * i < n ? -1 : 1, right = 2 * j < n ? -1 : 1;
    if (solid >= 0)
      for (const auto& [a, b] : {std::array{0, right}, {down, 0}, {down, right}, {0, -right}, {-down, 0}}) {
        const int row = r + a, column = c + b;
        if (row < 0 || column < 0 || row >= camera_.height || column >= camera_.width) continue;
        if (this->solid(row, column) == solid) return light(row, column);
      }
    return light_along(solid, float(c) + (float(j) + 0.5f) / n, float(r) + (float(i) + 0.5f) / n);
  }

 private:
  using Nearest = SolidSet::Nearest;

  // Shares of sun and sky that solids leave to a point.
  struct Past {
    float sun = -1, sky = -1;  // below zero: not known
  };
  // Light of a point of `solid`, seen along the ray, with the water that lies there.
  Vec3f wetted(const SetPoint& set, const Arrival& a, int solid, Vec3f ray) const {
    const Vec3f dry = compose(set, a);
    if (puddles_.empty()) return dry;
    return with_water(dry, puddles_, solid, solids()[std::size_t(solid)], camera_, ray,
                      a[snow_sun] * a[static_sun] * a[moving_sun],
                      a[snow_sky] * a[static_sky] * a[moving_sky], sky_, light_);
  }
  // Find one of the shares at a point of `self`.
  float arrival(Share share, const Solid& self, Vec3f point, const Hit& hit) const {
    switch (share) {
      case snow_sun: return sun_arrival(*snow_, light_, point);
      case snow_sky: return sky_arrival(*snow_, point, hit.normal);
      case static_sun:
      case moving_sun: return sun_past(set_, share == static_sun, self, point, hit, light_.sun);
      default: return sky_past(set_, share == static_sky, self, point, hit.normal);
    }
  }
  Vec3f light_along(int solid, float column, float row) const {
    const Vec3f ray = camera_.through(column, row);
    if (solid < 0) return sky_point(sky_, light_, ray).unshadowed;
    const Solid& self = solids()[std::size_t(solid)];
    const Hit hit = meet(self, camera_.eye, ray);
    if (hit.t > 1e20f) return sky_point(sky_, light_, ray).unshadowed;
    const Vec3f point = camera_.eye + ray * hit.t;
    Arrival here;
    for (Share s : shares_of_light) here[s] = arrival(s, self, point, hit);
    return wetted(set_point(self, hit, camera_, light_, sky_, ray), here, solid, ray);
  }
  std::size_t at(int i, int j) const { return std::size_t(i) * std::size_t(columns_) + std::size_t(j); }

  std::size_t pixel(int r, int c) const {
    return std::size_t(r) * std::size_t(camera_.width) + std::size_t(c);
  }

  // The triangle in front in the middle of a pixel.
  struct Front {
    float depth = 1e30f;
    std::uint32_t solid = 0, triangle = 0;
    auto operator<=>(const Front&) const = default;
  };
  void find_front(const Raster& meshes, std::vector<Front>& front) const {
    if (meshes.empty()) return;
#pragma omp parallel for schedule(dynamic)
    for (int first = 0; first < camera_.height; first += Raster::band)
      meshes.draw(first, std::min(first + Raster::band, camera_.height), 1,
                  [&](int r, int c, float depth, std::uint32_t solid, std::uint32_t triangle) {
                    const Front found{depth, solid, triangle};
                    front[pixel(r, c)] = std::min(front[pixel(r, c)], found);
                  });
  }
  // Meet what is nearest along a ray; front: in the place of the meshes, where that is known.
  Nearest nearest(Vec3f ray, const Front* front) const {
    Nearest found = set_.nearest(ray, !front);
    if (front && front->depth < found.hit.t) {
      const Hit hit = meet_triangle(solids()[front->solid], front->triangle, camera_.eye, ray);
      found = {int(front->solid), hit};
      found.hit.t = front->depth;
    }
    return found;
  }
  // What is in the middle of pixel (r, c), which may lie off the picture.
  Nearest nearest(int r, int c) const {
    const Vec3f ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
    const bool known = !front_.empty() && r < camera_.height && c < camera_.width;
    return nearest(ray, known ? &front_[pixel(r, c)] : nullptr);
  }

  // plain: whether a solid that is no mesh has moved; before: the triangles in front in the frame before.
  void place_row(int r, const std::vector<std::uint8_t>& moved, bool plain,
                 const std::vector<Front>& before) {
    const auto same = [&](int i, int j) {
      if (i < 0 || j < 0 || i >= camera_.height || j >= camera_.width) return true;
      const Front& front = front_[pixel(i, j)];
      return front == before[pixel(i, j)] && (front.depth > 1e20f || !moved[front.solid]);
    };
    const auto all_same = [&](int c) {
      for (int i = r - 1; i <= r + 1; ++i)
        for (int j = c - 1; j <= c + 1; ++j)
          if (!same(i, j)) return false;
      return true;
    };
    for (int c = 0; c < camera_.width; ++c) {
      // Whether a mesh has an edge in the pixel depends on what is beside it.
      if (!plain && (front_.empty() || all_same(c))) continue;
      const Nearest found = nearest(r, c);
      const std::size_t p = pixel(r, c);
      const bool mesh = found.solid >= 0 && solids()[std::size_t(found.solid)].mesh;
      if (found.solid == solid_[p] && (found.solid < 0 || !(moved[std::size_t(found.solid)] || mesh)))
        continue;
      solid_[p] = found.solid;
      past_[p] = {};
      replaced_[at(r / cell, c / cell)] = 1;
      const Vec3f ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
      if (found.solid < 0)
        point_[p] = sky_point(sky_, light_, ray);
      else if (mesh && edge(r, c, front_[p]))
        point_[p] = blended(solids()[std::size_t(found.solid)], found.hit, r, c);
      else
        point_[p] = set_point(solids()[std::size_t(found.solid)], found.hit, camera_, light_, sky_, ray);
    }
  }

  // Say whether a pixel beside this one shows a triangle of the same mesh that is turned or off this one's plane.
  bool edge(int r, int c, const Front& here) const {
    const auto differs = [&](int i, int j) {
      if (i < 0 || j < 0 || i >= camera_.height || j >= camera_.width) return false;
      const Front& there = front_[pixel(i, j)];
      if (there.solid != here.solid || there.triangle == here.triangle || there.depth > 1e20f) return false;
      const Solid& solid = solids()[here.solid];
      const Triangle& mine = solid.mesh->triangles()[here.triangle];
      const Point a = mine.area_vector(), b = solid.mesh->triangles()[there.triangle].area_vector();
      const double square = dot(a, a);
      if (dot(a, b) < 0.92 * std::sqrt(square * dot(b, b))) return true;
      const Vec3f beside = camera_.eye + camera_.through(float(j) + 0.5f, float(i) + 0.5f) * there.depth;
      const Point from =
          to_point(transposed_times(solid.place.rotation, beside - solid.place.centre)) - mine.a;
      return std::abs(dot(a, from)) > 1.5 * std::sqrt(square) * double(there.depth / camera_.focal);
    };
    return differs(r - 1, c) || differs(r + 1, c) || differs(r, c - 1) || differs(r, c + 1);
  }

  // Describe a pixel that an edge within one mesh crosses: the mean over its samples, each of which shows a triangle
  // that is in front in the middle of this pixel or of one beside it.
  SetPoint blended(const Solid& self, const Hit& middle, int r, int c) const {
    constexpr int n = Samples::per_axis;
    std::uint32_t triangles[9];
    std::size_t count = 0;
    for (int i = std::max(r - 1, 0); i <= std::min(r + 1, camera_.height - 1); ++i)
      for (int j = std::max(c - 1, 0); j <= std::min(c + 1, camera_.width - 1); ++j) {
        const Front& front = front_[pixel(i, j)];
        if (front.depth < 1e20f && &solids()[front.solid] == &self &&
            std::find(triangles, triangles + count, front.triangle) == triangles + count)
          triangles[count++] = front.triangle;
      }
    SetPoint sum{};
    for (int s = 0; s < n * n; ++s) {
      Vec3f ray = camera_.through(float(c) + (float(s % n) + 0.5f) / n, float(r) + (float(s / n) + 0.5f) / n);
      Hit hit = meet_triangles(self, {triangles, count}, camera_.eye, ray);
      if (hit.t > 1e20f) hit = middle, ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
      const SetPoint set = set_point(self, hit, camera_, light_, sky_, ray);
      sum.sun += set.sun, sum.sky += set.sky, sum.unshadowed += set.unshadowed;
    }
    constexpr float part = 1.0f / (n * n);
    return {sum.sun * part, sum.sky * part, sum.unshadowed * part};
  }

  bool node_shows(const Samples& samples, int i, int j) const {
    for (int a = std::max(i - 1, 0); a <= std::min(i, samples.cell_rows() - 1); ++a)
      for (int b = std::max(j - 1, 0); b <= std::min(j, samples.cell_columns() - 1); ++b)
        if (samples.shows_solid[samples.cell_at(a, b)]) return true;
    return false;
  }
  // Find what arrives at a node and return whether anything is other than it was.
  bool light_node(Node& node, int i, int j) const {
    bool changed = false;
    if (!node.placed) {
      const Nearest found = nearest(i * cell, j * cell);
      const bool same = found.solid >= 0 && found.solid == node.solid &&
                        solids()[std::size_t(found.solid)].is_static && found.hit == node.hit;
      if (!same) node.arrival[static_sun] = node.arrival[static_sky] = -1, changed = true;
      const Vec3f ray = camera_.through(float(j * cell) + 0.5f, float(i * cell) + 0.5f);
      node.point = camera_.eye + ray * found.hit.t, node.hit = found.hit, node.solid = found.solid;
      node.placed = true;
    }
    if (node.solid < 0) return changed;
    const Solid& self = solids()[std::size_t(node.solid)];
    for (Share s : shares_of_light) {
      const bool kept = (s == static_sun || s == static_sky) && node.arrival[s] >= 0;
      if (kept) continue;
      const float before = node.arrival[s];
      node.arrival[s] = arrival(s, self, node.point, node.hit);
      changed = changed || node.arrival[s] != before;
    }
    return changed;
  }

  // Interpolate what arrives at pixel (r, c) from the four nodes around it, or find it anew where they
  // differ.
  Arrival between_nodes(int r, int c, int solid) const {
    const Corners nodes = corners(r / cell, c / cell);
    const bool same = nodes.show(solid);
    const float a = float(r % cell) / cell, b = float(c % cell) / cell;
    const Solid& self = solids()[std::size_t(solid)];
    const Vec3f ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
    Hit hit;
    Arrival here;
    for (Share s : shares_of_light) {
      if (same && nodes.alike(s, snow_->cell_size())) {
        here[s] = nodes.between(s, a, b);
        continue;
      }
      float* known = !self.is_static   ? nullptr
                     : s == static_sun ? &past_[pixel(r, c)].sun
                     : s == static_sky ? &past_[pixel(r, c)].sky
                                       : nullptr;
      if (known && recall(*known, here[s])) continue;
      if (hit.t > 1e20f) hit = self.mesh ? nearest(r, c).hit : meet(self, camera_.eye, ray);
      here[s] = arrival(s, self, camera_.eye + ray * hit.t, hit);
      if (known) __atomic_store(known, &here[s], __ATOMIC_RELAXED);
    }
    return here;
  }
  // Several threads may come to know the same share at once.
  static bool recall(const float& known, float& share) {
    __atomic_load(&known, &share, __ATOMIC_RELAXED);
    return share >= 0;
  }

  Corners corners(int i, int j) const {
    return {{&node_[at(i, j)], &node_[at(i, j + 1)], &node_[at(i + 1, j)], &node_[at(i + 1, j + 1)]}};
  }

  Camera camera_;
  Light light_;
  Sky sky_;
  std::size_t size_;
  std::vector<int> solid_;
  std::vector<SetPoint> point_;
  mutable std::vector<Past> past_;  // what solids at rest leave to pixels that show one of them
  int rows_, columns_;              // of the lattice
  std::vector<Node> node_;
  std::vector<std::uint8_t>
      replaced_;        // cells of which a pixel shows something else than in the frame before
  bool known_ = false;  // whether still_front_ is that of the solids
  bool any_ = false;    // whether anything has moved since the frame before
  SolidSet set_;
  std::vector<Front> still_front_, front_;  // of the meshes at rest and of all; empty without any
  std::span<const Puddle> puddles_;         // of this frame
  const Density* snow_ = nullptr;
};

}  // namespace neve::render
