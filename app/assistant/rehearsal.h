// What the simulated hand of an emulated device does where the assistant asks a person to.
#pragma once

#include "engine/session/session.h"

#include <cstddef>

namespace springdrive::app::assistant {

/// Moves one joint by this angle, and back.
/// @throw InputError as Session::follow_path does
void move_joint(session::Session &session, std::size_t joint, double angle_rad);

/// Holds the device in its zero pose. @throw the same
void hold_zero_pose(session::Session &session);

/// Holds the tip above the scene. @throw the same
void hold_above(session::Session &session);

/// Presses the tip into the scene where it is, some millimetres deep, and lifts it again.
/// @throw the same
void press_and_lift(session::Session &session);

} // namespace springdrive::app::assistant
