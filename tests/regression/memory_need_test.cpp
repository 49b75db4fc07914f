/// What --dry-run says of memory: the estimate, and the warning where it does not fit.
#include "case/memory_need.hpp"

#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

TEST(MemoryNeed, FactorsAreMostOfADirectSolution) {
  CoupledCase coupled(single_beam());
  const cases::MemoryNeed iterative = cases::memory_need(coupled.setup, false),
                          direct = cases::memory_need(coupled.setup, true);
  EXPECT_FALSE(cases::is_solved_directly(coupled.setup));
  EXPECT_EQ(iterative.factors, 0.0);
  // Measured peaks of one rank: 68 MiB and 720 MiB.
  if (coupled.comm().size() == 1) {
    EXPECT_NEAR(iterative.total(), 68e6 * 1.05, 0.35 * 68e6);
    EXPECT_NEAR(direct.total(), 720e6 * 1.05, 0.35 * 720e6);
  }
}

// Vectors of the Krylov iteration in doubles take more.
TEST(MemoryNeed, DependsOnThePrecision) {
  const auto fluid = [](const char* change) {
    CoupledCase coupled(single_beam(change));
    return cases::memory_need(coupled.setup, false).fluid;
  };
  const double mixed = fluid("{}");
  EXPECT_GT(fluid(R"({"solver": {"precision": "double"}})"), 1.5 * mixed);
  EXPECT_GT(fluid(R"({"fluid": {"pressure_stabilization": "projection"}})"), 1.5 * mixed);
}

TEST(MemoryNeed, WarnsAndSaysHowToNeedLess) {
  CoupledCase coupled(single_beam());
  const cases::MemoryNeed iterative = cases::memory_need(coupled.setup, false),
                          direct = cases::memory_need(coupled.setup, true);
  EXPECT_EQ(cases::memory_warning(coupled.setup, direct, 1e12), "");
  const std::string factors = cases::memory_warning(coupled.setup, direct, 1e7);
  EXPECT_NE(factors.find("not enough memory: the run needs about"), std::string::npos) << factors;
  EXPECT_NE(factors.find("\"iterative\""), std::string::npos) << factors;
  cases::MemoryNeed large = iterative;
  large.fluid = 1e13;
  const std::string fields = cases::memory_warning(coupled.setup, large, 1e7);
  EXPECT_NE(fields.find("use fewer elements"), std::string::npos) << fields;
  EXPECT_EQ(fields.find("iterative"), std::string::npos) << fields;
}

}  // namespace
}  // namespace fbi::test
