// The map of docs/pressure-stabilization.md: errors and roughness of the pressure on a fixed mesh against the time
// step, over five decades. With FBI_RECORDS the numbers go to pressure-stabilization.dat there.
#include "convergence/pressure_study.hpp"

#include <gtest/gtest.h>

namespace fbi::fluid::test {
namespace {

std::string row(double number, double viscosity, const std::vector<PressureErrors>& errors) {
  char text[100];
  std::snprintf(text, sizeof text, "%g %.2e", viscosity, number);
  std::string line = text;
  for (const PressureErrors& e : errors) {
    std::snprintf(text, sizeof text, "  %.4e %.4e %.4e", e.velocity, e.pressure, e.roughness);
    line += text;
  }
  return line + "\n";
}

TEST(PressureStudy, ErrorsAgainstTheTimeStep) {
  linalg::initialize_petsc();
  const char* folder = std::getenv("FBI_RECORDS");
  std::FILE* file =
      folder != nullptr ? std::fopen((std::string(folder) + "/pressure-stabilization.dat").c_str(), "w") : nullptr;
  const auto line = [&](const char* text) {
    std::fputs(text, stdout);
    if (file != nullptr) std::fputs(text, file);
  };
  line("# Ethier-Steinman flow, 8 x 8 x 8 cells, implicit Euler from the nodal values of the exact velocity\n");
  line(
      "# columns: mu, mu dt/(rho h^2), then velocity error, pressure error, roughness after 1, 2 and 10 steps (or at "
      "the time named)\n");
  const std::vector<int> steps = {1, 2, 10};
  for (const double viscosity : {1.0, 0.01})
    for (const Method& method : methods) {
      const PressureStudy study(8, viscosity, method);
      line(("\n\n\"" + std::string(method.name) + (viscosity == 1.0 ? "\"\n" : ", mu = 0.01\"\n")).c_str());
      for (int decade = 0; decade >= -5; --decade) {
        const double dt = std::pow(10.0, decade) / study.number(1.0);
        if (dt > 1) continue;  // the time step resolves nothing
        const std::vector<PressureErrors> e = study.run(dt, steps);
        line(row(study.number(dt), viscosity, e).c_str());
        for (const PressureErrors& at : e) EXPECT_TRUE(std::isfinite(at.pressure)) << method.name << " dt " << dt;
      }
    }
  // From a developed flow: ten steps of 0.1 rho h^2/mu, then the small ones.
  for (const Method& method : methods) {
    const PressureStudy study(8, 1.0, method);
    line(("\n\n\"" + std::string(method.name) + ", step reduced\"\n").c_str());
    for (int decade = -1; decade >= -4; --decade) {  // below, nothing but round-off is left to solve for
      const double unit = 1 / study.number(1.0), dt = std::pow(10.0, decade) * unit;
      line(row(study.number(dt), 1.0, study.run(dt, steps, 10, 0.1 * unit)).c_str());
    }
  }
  // A fixed time, reached by more and more steps.
  for (const Method& method : methods) {
    const PressureStudy study(8, 1.0, method);
    line(("\n\n\"" + std::string(method.name) + ", at t = 0.1 rho h^2/mu\"\n").c_str());
    for (const int count : {1, 3, 10, 30, 100, 300}) {
      const double dt = 0.1 / count / study.number(1.0);
      line(row(study.number(dt), 1.0, study.run(dt, {count})).c_str());
    }
  }
  if (file != nullptr) std::fclose(file);
}

}  // namespace
}  // namespace fbi::fluid::test
