/// Markdown reference of a field table, for people.
#pragma once

#include <string>

#include "input/visitor.hpp"

namespace fbi::input {

/// One section for the object that `describe` describes and one for each kind of object inside it, as Markdown.
std::string reference_page(const std::string& title, const Visitor::Describe& describe);

}  // namespace fbi::input
