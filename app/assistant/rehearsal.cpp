#include "app/assistant/rehearsal.h"

#include "base/error_text.h"

namespace springdrive::app::assistant {

void offer_hand(session::Session &session, const char *what, std::function<void()> act,
                std::string &error, std::vector<Offer> &offers) {
    if (session.device().emulated() != nullptr) {
        offers.push_back({"let the simulated hand do it",
                          std::string("an emulated device: ") + what,
                          [act = std::move(act), &error] { error = error_text_of(act); },
                          !session.hand().follows_path()});
    }
}

void hold_zero_pose(session::Session &session) {
    session.follow_path(simulated::HandPath({{0.0, Vector3::Zero()}}));
}

} // namespace springdrive::app::assistant
