#include "base/counters.hpp"

#include <gtest/gtest.h>

namespace fbi {
namespace {

TEST(Counters, WorkTogetherIsCountedOnceAndPartsAddUp) {
  const Comm comm;
  reset_counters();
  count("solves", 2);
  count("solves");
  count_parts("pieces", comm.rank() + 1);
  if (comm.rank() == comm.size() - 1) count_parts("seen by one rank", 5);
  EXPECT_EQ(counted("solves"), 3);
  EXPECT_EQ(counted("never"), 0);
  const std::vector<Counted> work = counted_work(comm);
  ASSERT_EQ(work.size(), 3U);
  EXPECT_EQ(work[0].what, "pieces");
  EXPECT_EQ(work[0].number, comm.size() * (comm.size() + 1) / 2);
  EXPECT_EQ(work[1].what, "seen by one rank");
  EXPECT_EQ(work[1].number, 5);
  EXPECT_EQ(work[2].what, "solves");
  EXPECT_EQ(work[2].number, 3);
  EXPECT_NE(counter_report(work).find("seen by one rank"), std::string::npos);
  reset_counters();
  EXPECT_TRUE(counted_work(comm).empty());
}

}  // namespace
}  // namespace fbi
