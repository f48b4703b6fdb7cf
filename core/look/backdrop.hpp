// The set in every pixel: which body or sky is there and how it takes the light. What does not move is
// described once per film; sun and sky are found anew in each frame, on a coarse lattice where they vary
// slowly.
#pragma once
#include <array>

#include "look/ground.hpp"
#include "look/splat.hpp"

namespace neve::look {

class Backdrop {
 public:
  Backdrop(const Camera& camera, const Light& light)
      : camera_(camera),
        light_(light),
        sky_(light),
        size_(size_t(camera.width) * size_t(camera.height)),
        body_(size_, unknown),
        point_(size_),
        rows_((camera.height - 1) / cell + 2),
        columns_((camera.width - 1) / cell + 2) {}

  const Sky& sky() const { return sky_; }

  /// Take in the bodies of this frame: describe the pixels that show something that was not there before.
  void place(const std::vector<Body>& bodies, const Raster& meshes) {
    std::vector<uint8_t> moved(bodies.size(), 1);
    bool any = bodies.size() != bodies_.size();
    for (size_t b = 0; b < bodies.size(); ++b) {
      moved[b] = b >= bodies_.size() || !(bodies[b] == bodies_[b]);
      any = any || moved[b];
    }
    bodies_ = bodies;
    if (!any && known_) return;
    known_ = true;
    front_.assign(meshes.empty() ? 0 : size_, Front{});
    if (!meshes.empty()) {
#pragma omp parallel for schedule(dynamic)
      for (int first = 0; first < camera_.height; first += Raster::band)
        meshes.draw(first, std::min(first + Raster::band, camera_.height), 1,
                    [&](int r, int c, float depth, uint32_t body, uint32_t triangle) {
                      Front& front = front_[pixel(r, c)];
                      if (depth < front.depth) front = {depth, body, triangle};
                    });
    }
#pragma omp parallel for schedule(dynamic, 8)
    for (int r = 0; r < camera_.height; ++r) place_row(r, moved);
  }

  /// Find sun and sky on the lattice wherever one of the cells around a node shows the set.
  void illuminate(const Density& snow, const Samples& samples) {
    snow_ = &snow;
    std::vector<uint8_t> shows(size_t(rows_) * size_t(columns_), 0);
    node_.assign(shows.size(), Node{});
#pragma omp parallel
    {
#pragma omp for schedule(dynamic, 4)
      for (int i = 0; i < rows_ - 1; ++i) look_at_cells(i, samples, shows);
#pragma omp for schedule(dynamic, 4)
      for (int i = 0; i < rows_; ++i)
        for (int j = 0; j < columns_; ++j)
          if (node_shows(shows, i, j)) node_[at(i, j)] = light_node(i, j);
    }
  }

  /// Light of the set in pixel (r, c).
  Vec3 light(int r, int c) const {
    const size_t p = pixel(r, c);
    const SetPoint& set = point_[p];
    const int body = body_[p];
    if (body < 0) return set.rest;
    return compose(set, between_nodes(r, c, body));
  }

  /// The body in the middle of pixel (r, c); -1 is the sky.
  int body(int r, int c) const { return body_[pixel(r, c)]; }

  /// Light of one body (or of the sky, -1) along the ray through a point of the picture [px]: the edges of
  /// bodies.
  Vec3 light_along(int body, float column, float row) const {
    const Vec3 ray = camera_.through(column, row);
    if (body < 0) return sky_point(sky_, light_, ray).rest;
    const Body& self = bodies_[size_t(body)];
    const Hit hit = meet(self, camera_.eye, ray);
    if (hit.t > 1e20f) return sky_point(sky_, light_, ray).rest;
    const SetPoint set = set_point(self, hit, camera_, light_, sky_, ray);
    return compose(set, arrival(self, camera_.eye + ray * hit.t, hit));
  }

 private:
  static constexpr int cell = 4;  // pixels between the nodes of the lattice
  static constexpr int16_t unknown = -2;
  // Between nodes that differ by more than this the light is found pixel by pixel.
  static constexpr float smooth = 0.06f;

  /// What arrives at a point of the set: shares of the sun past the snow and past the bodies, and of the sky.
  struct Arrival {
    float snow = 1, bodies = 1, sky = 1;
  };
  struct Node {
    Arrival arrival;
    Vec3 point;
    int body = unknown;
  };

  static Vec3 compose(const SetPoint& set, Arrival a) {
    return set.sun * (a.snow * a.bodies) + set.sky * a.sky + set.rest;
  }
  size_t at(int i, int j) const { return size_t(i) * size_t(columns_) + size_t(j); }

  size_t pixel(int r, int c) const { return size_t(r) * size_t(camera_.width) + size_t(c); }

  /// The triangle in front in the middle of a pixel.
  struct Front {
    float depth = 1e30f;
    uint32_t body = 0, triangle = 0;
    bool operator==(const Front&) const = default;
  };
  struct Nearest {
    int body = -1;
    Hit hit;
  };
  /// Meet what is nearest along a ray; front: in the place of the meshes, where that is known.
  Nearest nearest(Vec3 ray, const Front* front) const {
    Nearest found;
    for (size_t b = 0; b < bodies_.size(); ++b) {
      if (front && bodies_[b].shape == Shape::mesh) continue;
      const Hit hit = meet(bodies_[b], camera_.eye, ray);
      if (hit.t < found.hit.t) found = {int(b), hit};
    }
    if (front && front->depth < found.hit.t) {
      const Hit hit = meet_triangle(bodies_[front->body], front->triangle, camera_.eye, ray);
      found = {int(front->body), hit};
      found.hit.t = front->depth;
    }
    return found;
  }
  /// What is in the middle of pixel (r, c), which may lie off the picture.
  Nearest nearest(int r, int c) const {
    const Vec3 ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
    const bool known = !front_.empty() && r < camera_.height && c < camera_.width;
    return nearest(ray, known ? &front_[pixel(r, c)] : nullptr);
  }

  void place_row(int r, const std::vector<uint8_t>& moved) {
    for (int c = 0; c < camera_.width; ++c) {
      const Nearest found = nearest(r, c);
      const size_t p = pixel(r, c);
      const bool mesh = found.body >= 0 && bodies_[size_t(found.body)].shape == Shape::mesh;
      // Whether a mesh has an edge in the pixel depends on what is beside it.
      if (found.body == body_[p] && (found.body < 0 || !(moved[size_t(found.body)] || mesh))) continue;
      body_[p] = int16_t(found.body);
      const Vec3 ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
      if (found.body < 0)
        point_[p] = sky_point(sky_, light_, ray);
      else if (mesh && edge(r, c, front_[p]))
        point_[p] = blended(bodies_[size_t(found.body)], found.hit, r, c);
      else
        point_[p] = set_point(bodies_[size_t(found.body)], found.hit, camera_, light_, sky_, ray);
    }
  }

  /// Say whether a pixel beside this one shows a triangle of the same mesh that is turned or off this one's plane.
  bool edge(int r, int c, const Front& here) const {
    const auto differs = [&](int i, int j) {
      if (i < 0 || j < 0 || i >= camera_.height || j >= camera_.width) return false;
      const Front& there = front_[pixel(i, j)];
      if (there.body != here.body || there.triangle == here.triangle || there.depth > 1e20f) return false;
      const Body& body = bodies_[here.body];
      const Triangle& mine = body.mesh->triangles()[here.triangle];
      const Point a = mine.area_vector(), b = body.mesh->triangles()[there.triangle].area_vector();
      const double square = dot(a, a);
      if (dot(a, b) < 0.92 * std::sqrt(square * dot(b, b))) return true;
      const Vec3 beside = camera_.eye + camera_.through(float(j) + 0.5f, float(i) + 0.5f) * there.depth;
      const Point from = to_point(body.turn.to_local(beside - body.position)) - mine.a;
      return std::abs(dot(a, from)) > 1.5 * std::sqrt(square) * double(there.depth / camera_.focal);
    };
    return differs(r - 1, c) || differs(r + 1, c) || differs(r, c - 1) || differs(r, c + 1);
  }

  /// Describe a pixel that an edge within one mesh crosses: the mean over its samples.
  SetPoint blended(const Body& self, const Hit& middle, int r, int c) const {
    constexpr int n = Samples::per_axis;
    SetPoint sum{};
    for (int s = 0; s < n * n; ++s) {
      Vec3 ray = camera_.through(float(c) + (float(s % n) + 0.5f) / n, float(r) + (float(s / n) + 0.5f) / n);
      Hit hit = meet(self, camera_.eye, ray);
      if (hit.t > 1e20f) hit = middle, ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
      const SetPoint set = set_point(self, hit, camera_, light_, sky_, ray);
      sum.sun += set.sun, sum.sky += set.sky, sum.rest += set.rest;
    }
    constexpr float part = 1.0f / (n * n);
    return {sum.sun * part, sum.sky * part, sum.rest * part};
  }

  void look_at_cells(int i, const Samples& samples, std::vector<uint8_t>& shows) const {
    constexpr int n = cell * Samples::per_axis;
    for (int r = i * n; r < std::min((i + 1) * n, samples.height); ++r) {
      const Key* row = samples.row(r);
      for (int c = 0; c < samples.width; ++c)
        if (row[c] != nothing && index_of(row[c]) >= first_body) shows[at(i, c / n)] = 1;
    }
  }
  bool node_shows(const std::vector<uint8_t>& shows, int i, int j) const {
    for (int a = std::max(i - 1, 0); a <= i; ++a)
      for (int b = std::max(j - 1, 0); b <= j; ++b)
        if (shows[at(a, b)]) return true;
    return false;
  }
  Node light_node(int i, int j) const {
    const Vec3 ray = camera_.through(float(j * cell) + 0.5f, float(i * cell) + 0.5f);
    const Nearest found = nearest(i * cell, j * cell);
    if (found.body < 0) return {};
    const Vec3 point = camera_.eye + ray * found.hit.t;
    return {arrival(bodies_[size_t(found.body)], point, found.hit), point, found.body};
  }
  Arrival arrival(const Body& self, Vec3 point, const Hit& hit) const {
    return {sun_arrival(*snow_, light_, point), sun_past(bodies_, self, point, hit, light_.sun),
            sky_arrival(*snow_, bodies_, self, point, hit.normal)};
  }

  /// Interpolate what arrives at pixel (r, c) from the four nodes around it, or find it anew where they
  /// differ.
  Arrival between_nodes(int r, int c, int body) const {
    const int i = r / cell, j = c / cell;
    const Corners nodes{&node_[at(i, j)], &node_[at(i, j + 1)], &node_[at(i + 1, j)],
                        &node_[at(i + 1, j + 1)]};
    const bool same =
        std::all_of(nodes.begin(), nodes.end(), [body](const Node* n) { return n->body == body; });
    const float a = float(r % cell) / cell, b = float(c % cell) / cell;
    Arrival here;
    const bool snow = same && between(nodes, &Arrival::snow, snow_tolerance(nodes), a, b, here.snow);
    const bool past = same && between(nodes, &Arrival::bodies, smooth, a, b, here.bodies);
    const bool sky = same && between(nodes, &Arrival::sky, smooth, a, b, here.sky);
    if (snow && past && sky) return here;
    const Vec3 ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
    const Body& self = bodies_[size_t(body)];
    const Hit hit = self.shape == Shape::mesh ? nearest(r, c).hit : meet(self, camera_.eye, ray);
    const Vec3 point = camera_.eye + ray * hit.t;
    if (!snow) here.snow = sun_arrival(*snow_, light_, point);
    if (!past) here.bodies = sun_past(bodies_, self, point, hit, light_.sun);
    if (!sky) here.sky = sky_arrival(*snow_, bodies_, self, point, hit.normal);
    return here;
  }

  using Corners = std::array<const Node*, 4>;

  /// The snow's shadow has no details finer than the density's cells: nodes closer than that may differ.
  float snow_tolerance(const Corners& nodes) const {
    const Vec3 one = nodes[3]->point - nodes[0]->point, other = nodes[2]->point - nodes[1]->point;
    const float far = std::max(dot(one, one), dot(other, other)), near = 2.5f * snow_->cell_size();
    return std::clamp(0.12f * near * near / std::max(far, 1e-20f), smooth, 1.0f);
  }

  /// Interpolate one share between four nodes; say whether they are as alike as they need to be.
  static bool between(const Corners& nodes, float Arrival::* share, float tolerance, float a, float b,
                      float& value) {
    const float n00 = nodes[0]->arrival.*share, n01 = nodes[1]->arrival.*share;
    const float n10 = nodes[2]->arrival.*share, n11 = nodes[3]->arrival.*share;
    value = mix(mix(n00, n01, b), mix(n10, n11, b), a);
    return std::max({n00, n01, n10, n11}) - std::min({n00, n01, n10, n11}) < tolerance;
  }

  Camera camera_;
  Light light_;
  Sky sky_;
  size_t size_;
  std::vector<int16_t> body_;
  std::vector<SetPoint> point_;
  int rows_, columns_;  // of the lattice
  bool known_ = false;
  std::vector<Body> bodies_;
  std::vector<Node> node_;
  std::vector<Front> front_;  // empty without meshes
  const Density* snow_ = nullptr;
};

}  // namespace neve::look
