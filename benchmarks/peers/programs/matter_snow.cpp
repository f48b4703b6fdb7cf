// The block in Matter: matter_snow FILE THREADS, where FILE holds, in double, the number of particles, dx, density, Young's
// modulus, Poisson's ratio, gravity, friction of the ground, the volume of a particle, then x y z and velocity of each.
//
// Snow is Modified Cam-Clay with Hencky's elasticity, hardening exponentially, by Matter's implicit return mapping. Each line
// of the standard input is a number of seconds to simulate; the answer is the number of steps. An empty line is answered by x y
// z and velocity of each particle in binary, and ends the program.
#include <cstdio>
#include <string>

#include "objects/object_plate.hpp"
#include "simulation/simulation.hpp"
#include "tools.hpp"

// Nothing is saved.
void Simulation::saveParticleData(std::string) {}
void Simulation::saveGridData(std::string) {}
void Simulation::saveInfo() {}
void Simulation::saveTiming() {}

namespace {

// Matter's height is y.
TV turned(const double* a) { return {a[0], a[2], a[1]}; }

void set_snow(Simulation& sim) {
  sim.elastic_model = ElasticModel::Hencky;
  sim.plastic_model = PlasticModel::MCC;
  sim.hardening_law = HardeningLaw::ExpoImpl;
  sim.M = 1.2;     // slope of the critical state [1]
  sim.beta = 0.3;  // cohesion [1]
  sim.p0 = 2e3;    // pressure at which it is pressed together at first [Pa]
  sim.xi = 10;     // hardening [1]
}

// The last number after "Step: " in what Matter has printed.
long steps_in(const std::string& printed) {
  const std::size_t at = printed.rfind("Step: ");
  return at == std::string::npos ? 0 : std::stol(printed.substr(at + 6));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  std::FILE* file = std::fopen(arguments[1], "rb");
  double head[8];
  if (!file || std::fread(head, sizeof(double), 8, file) != 8) return 2;
  const auto n = static_cast<std::size_t>(head[0]);
  std::vector<double> rows(6 * n);
  if (std::fread(rows.data(), sizeof(double), rows.size(), file) != rows.size()) return 2;
  std::fclose(file);

  std::ostringstream printed;
  std::streambuf* out = std::cout.rdbuf(printed.rdbuf());
  Simulation sim;
  sim.initialize(false);
  sim.n_threads = static_cast<unsigned>(std::stoi(arguments[2]));
  sim.dx = head[1], sim.rho = head[2], sim.E = head[3], sim.nu = head[4];
  sim.gravity = TV::Zero(), sim.gravity[1] = head[5];
  sim.particle_volume = head[7], sim.particle_mass = head[2] * head[7];
  sim.Np = static_cast<unsigned>(n);
  sim.particles = Particles(sim.Np);
  for (std::size_t p = 0; p < n; ++p) {
    sim.particles.x[p] = turned(rows.data() + 6 * p);
    sim.particles.v[p] = turned(rows.data() + 6 * p + 3);
  }
  sim.grid_reference_point = TV::Zero();
  sim.plates.push_back(std::make_unique<ObjectPlate>(0, PlateType::bottom, BC::SlipFree, head[6]));
  set_snow(sim);

  std::string line;
  long before = -1;
  while (std::getline(std::cin, line) && !line.empty()) {
    printed.str("");
    sim.end_frame = 1, sim.fps = 1 / std::stod(line);
    sim.simulate();
    if (sim.exit) return 1;
    const long now = steps_in(printed.str());
    std::ostream(out) << now - before << std::endl;
    before = now;
  }
  for (std::size_t p = 0; p < n; ++p) {
    const TV x = turned(sim.particles.x[p].data()), v = turned(sim.particles.v[p].data());
    std::fwrite(x.data(), sizeof(double), 3, stdout), std::fwrite(v.data(), sizeof(double), 3, stdout);
  }
  return 0;
}
