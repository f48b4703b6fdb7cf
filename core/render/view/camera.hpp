// A pinhole camera: world points to pixels and back.
#pragma once

#include <numbers>

#include "render/view/vec.hpp"

namespace neve::render {

struct Camera {
  Vec3f eye, right, down, forward;
  int width, height;  // [px]
  float focal;        // [px]
  float reach;        // from the eye to what it looks at [m]: the length that the picture is about

  // fov: vertical field of view [degrees].
  Camera(Vec3f position, Vec3f target, Vec3f up, float fov, int width_px, int height_px)
      : eye(position), width(width_px), height(height_px) {
    reach = std::max(length(target - eye), 1e-6f);
    forward = normalize(target - eye);
    Vec3f side = cross(forward, up);
    if (length(side) < 1e-4f * length(up)) side = cross(forward, {0, 1, 0});  // looking straight up or down
    right = normalize(side);
    down = cross(forward, right);
    focal = 0.5f * float(height) / std::tan(0.5f * fov * std::numbers::pi_v<float> / 180.0f);
  }

  // Return (column, row, depth along the axis [m]); pixel (i, j) covers [i, i+1) x [j, j+1).
  Vec3f project(Vec3f p) const {
    const Vec3f d = p - eye;
    const float depth = dot(d, forward), scale = focal / depth;
    return {0.5f * float(width) + dot(d, right) * scale, 0.5f * float(height) + dot(d, down) * scale, depth};
  }

  // Return the direction through a point of the picture, scaled so that its depth is one.
  Vec3f through(float column, float row) const {
    return forward + right * ((column - 0.5f * float(width)) / focal) +
           down * ((row - 0.5f * float(height)) / focal);
  }
};

}  // namespace neve::render
