// The assistant in the window: its steps on the left, the present one on the right.
#pragma once

#include "app/assistant/assistant.h"
#include "app/panels/doctor_popup.h"
#include "app/widgets/rectangle.h"

namespace springdrive::app {

void draw_assistant_panel(session::Session &session, assistant::Assistant &assistant,
                          DoctorPopup &doctor, const Rectangle &place);

/// A button that opens it, and why it holds the device.
void offer_assistant(session::Session &session, assistant::Assistant &assistant);

} // namespace springdrive::app
