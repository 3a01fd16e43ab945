// What the page says wherever software may not be enough: which emergency stop is meant, since Esc on a page is none; pure.
export const EMERGENCY = "press the red emergency stop at the robot, or have it pressed";
