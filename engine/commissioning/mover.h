// What moves a device where a person is asked to, such as a simulated hand.
#pragma once

#include <functional>

namespace springdrive::commissioning {

/// Called once, when the motion begins; empty: a person moves it.
/// @param longest_s  that the motion may last
/// @return how long it lasts [s]
using Mover = std::function<double(double longest_s)>;

} // namespace springdrive::commissioning
