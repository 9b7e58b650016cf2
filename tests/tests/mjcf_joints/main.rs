//! Joints of models in MJCF: their frames against MuJoCo's kinematics, their forces against closed forms.

mod forces;
mod frames;
