// Linked into every program of a sanitizer build. Open MPI unloads its plugins with memory they still hold, so leaks are
// not looked for at the exit; the tests look for them before MPI_Finalize, with what libraries keep left out.
extern "C" const char* __asan_default_options() { return "leak_check_at_exit=0"; }
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libmpi\nleak:libopen-pal\nleak:libopen-rte\nleak:libpmix\nleak:libhwloc\nleak:libevent\nleak:mca_\nleak:vasprintf\n"
         "leak:libpetsc\nleak:libhdf5\nleak:libcurl\nleak:libcrypto\nleak:libucs\nleak:libucp\nleak:libgomp\n";
}
