// What the simulated hand of an emulated device does where the assistant asks a person to.
#pragma once

#include "app/assistant/step.h"

namespace springdrive::app::assistant {

/// Offers that the hand does it, if there is one, and is free.
/// @param what       "its hand moves this joint, and back"
/// @param act        may throw InputError
/// @param error  gets why it does not act, or nothing; outlives the offer
void offer_hand(session::Session &session, const char *what, std::function<void()> act,
                std::string &error, std::vector<Offer> &offers);

/// Holds the device in its zero pose. @throw InputError as Session::follow_path does
void hold_zero_pose(session::Session &session);

} // namespace springdrive::app::assistant
