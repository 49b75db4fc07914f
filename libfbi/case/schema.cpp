#include "case/schema.hpp"
