/// JSON Schema (draft 2020-12) of a field table, for editors.
#pragma once

#include <string>

#include "input/visitor.hpp"

namespace fbi::input {

/// The schema of the object that `describe` describes, as text.
std::string json_schema(const std::string& title, const Visitor::Describe& describe);

}  // namespace fbi::input
