//! Mechanics: laws, elements, contact, equilibrium, load paths, dynamics; against closed forms and other codes.

#[path = "../fixtures/common.rs"]
mod common;
#[path = "../fixtures/keep.rs"]
mod keep;

mod condensed;
mod contact_fold;
mod contact_project;
mod derivatives;
mod dynamics;
mod engine;
mod feats;
mod path;
mod press;
mod push;
mod reference;
mod scales;
mod verification_convergence;
mod verification_hertz;
mod verification_scene;
