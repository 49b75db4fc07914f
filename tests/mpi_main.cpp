/// Main program of every test: MPI on, other ranks silent, a failure on any rank fails the test, floating-point traps on.
/// In a sanitizer build leaks fail it too.
#include <cfenv>
#include <mpi.h>

#include <gtest/gtest.h>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

int main(int argc, char** argv) {
#ifdef __SANITIZE_ADDRESS__
  __lsan_disable();  // what MPI_Init allocates is MPI's own
#endif
  MPI_Init(&argc, &argv);
#ifdef __SANITIZE_ADDRESS__
  __lsan_enable();
#endif
  ::testing::InitGoogleTest(&argc, argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) {
    ::testing::TestEventListeners& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
  }
  feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);
  int failed = RUN_ALL_TESTS();
  fedisableexcept(FE_ALL_EXCEPT);
#ifdef __SANITIZE_ADDRESS__
  if (__lsan_do_recoverable_leak_check() != 0) failed = 1;
#endif
  int any = 0;
  MPI_Allreduce(&failed, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return any;
}
