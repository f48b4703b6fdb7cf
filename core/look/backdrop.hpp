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
  void place(const std::vector<Body>& bodies) {
    std::vector<uint8_t> moved(bodies.size(), 1);
    bool any = bodies.size() != bodies_.size();
    for (size_t b = 0; b < bodies.size(); ++b) {
      moved[b] = b >= bodies_.size() || !(bodies[b] == bodies_[b]);
      any = any || moved[b];
    }
    bodies_ = bodies;
    if (!any && known_) return;
    known_ = true;
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
    const size_t p = size_t(r) * size_t(camera_.width) + size_t(c);
    const SetPoint& set = point_[p];
    const int body = body_[p];
    if (body < 0) return set.rest;
    return compose(set, between_nodes(r, c, body));
  }

  /// The body in the middle of pixel (r, c); -1 is the sky.
  int body(int r, int c) const { return body_[size_t(r) * size_t(camera_.width) + size_t(c)]; }

  /// Light of one body (or of the sky, -1) along the ray through a point of the picture [px]: the edges of
  /// bodies.
  Vec3 light_along(int body, float column, float row) const {
    const Vec3 ray = camera_.through(column, row);
    if (body < 0) return sky_point(sky_, light_, ray).rest;
    const Body& self = bodies_[size_t(body)];
    const Hit hit = meet(self, camera_.eye, ray);
    if (hit.t > 1e20f) return sky_point(sky_, light_, ray).rest;
    const SetPoint set = set_point(self, hit, camera_, light_, sky_, ray);
    return compose(set, arrival(self, camera_.eye + ray * hit.t, hit.normal));
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

  struct Nearest {
    int body = -1;
    Hit hit;
  };
  Nearest nearest(Vec3 ray) const {
    Nearest found;
    for (size_t b = 0; b < bodies_.size(); ++b) {
      const Hit hit = meet(bodies_[b], camera_.eye, ray);
      if (hit.t < found.hit.t) found = {int(b), hit};
    }
    return found;
  }

  void place_row(int r, const std::vector<uint8_t>& moved) {
    for (int c = 0; c < camera_.width; ++c) {
      const Vec3 ray = camera_.through(float(c) + 0.5f, float(r) + 0.5f);
      const Nearest found = nearest(ray);
      const size_t p = size_t(r) * size_t(camera_.width) + size_t(c);
      if (found.body == body_[p] && (found.body < 0 || !moved[size_t(found.body)])) continue;
      body_[p] = int16_t(found.body);
      point_[p] = found.body < 0
                      ? sky_point(sky_, light_, ray)
                      : set_point(bodies_[size_t(found.body)], found.hit, camera_, light_, sky_, ray);
    }
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
    const Nearest found = nearest(ray);
    if (found.body < 0) return {};
    const Vec3 point = camera_.eye + ray * found.hit.t;
    return {arrival(bodies_[size_t(found.body)], point, found.hit.normal), point, found.body};
  }
  Arrival arrival(const Body& self, Vec3 point, Vec3 normal) const {
    return {sun_arrival(*snow_, light_, point), sun_past(bodies_, &self, point, light_.sun),
            sky_arrival(*snow_, bodies_, self, point, normal)};
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
    const Hit hit = meet(self, camera_.eye, ray);
    const Vec3 point = camera_.eye + ray * hit.t;
    if (!snow) here.snow = sun_arrival(*snow_, light_, point);
    if (!past) here.bodies = sun_past(bodies_, &self, point, light_.sun);
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
  const Density* snow_ = nullptr;
};

}  // namespace neve::look
