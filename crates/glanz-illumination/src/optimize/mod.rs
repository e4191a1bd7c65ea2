//! Inverse design: moves numbers of a scene until the light of its lamps, reflected once by its mirrors, is as wanted.
//!
//! # What is moved and what is wanted
//! The description of a scene names its variables and targets ([`DesignDescription`](glanz_scene::description::DesignDescription)): displacements of control points, in groups that move together,
//! of shapes, of point lights, and of radii; and evenness, a distribution, a peak or all light on a flat rectangular receiver, or the collimation of the light from a mirror.
//!
//! # Rays
//! A ray is given by its parameters: (u, v) on a mirror and a point of a light, both by a scrambled Sobol' sequence. It starts at the light, is aimed at the point P(u, v) of the mirror, and
//! is reflected at the normal there. Its flux is
//!
//! ```text
//! L cos cos / r^2 |P_u x P_v| du dv dA   (area),   I cos / r^2 |P_u x P_v| du dv   (point),
//! ```
//!
//! so that sums over rays integrate over fixed domains. No ray is intersected with the mirror, and none crosses its border: its flux and direction are smooth functions of the
//! displacements (`reflection`), and so are the merits, but where a ray becomes parallel to the plane of a receiver. Rays traced from the light into fixed directions need the implicit function theorem where they meet the mirror, and appear and vanish at its borders; their sums are not continuous.
//! With fixed weights, P and its derivatives are linear in the control points (`surface_basis`), so that a ray needs the basis functions of the variables at its parameters only, computed once.
//! Shadows and reflectances are those of the scene itself, traced at the beginning of each round of the search, and constant during it (`ray_model`). A round whose
//! displacements are worse with their own shadows is given up. Light that something blocks behind a mirror counts in the total.
//!
//! # Merits
//! A merit is a function of sums over rays, 0 for the ideal (`merit`). For a distribution these are the shares of the light in cells, by quadratic B-splines of the size of a cell, at several sizes from the
//! receiver's own cells to half of it: the sum of the squared differences from the wanted shares over the sum of the squares of these, and the mean over all sizes. The small cells alone have no gradient where light
//! and wanted light do not overlap; all of them at once lead to caustics, so that sizes below a twelfth of the receiver are added one after the other (`search`). Beyond the receiver the coordinates are logarithmic, so that light may begin anywhere on its plane. A merit by the squared deviations of the cells' illuminance from their mean alone
//! has its minimum where all light has left the receiver.
//!
//! # Derivatives
//! The gradient is that of the sums with fixed rays, by the reverse mode: the derivatives by the sums, by the rays, by their ends, and by the variables; its cost is that of about two more evaluations
//! of the merit, whatever the number of variables. The search is L-BFGS (@nocedal2006 section 7.2) with the line search of @more1994 on variables that a sine keeps in their ranges. Radii, positions of receivers, and control points of lamps and receivers are found without
//! derivatives, and all other variables with them, by the simplex method (@nelder1965), which builds the rays anew for every step.
//!
//! # Limits
//! Light after one reflection counts; direct light, and light after several, does not. Lights are surfaces of uniform radiance and points without a direction. Mirrors in groups do not take part.
//! `glanz illuminate` verifies a result with all light.

mod error;
mod landing_grid;
mod merit;
mod ray_model;
mod ray_sources;
mod reflection;
mod scaled_problem;
mod search;
mod sensitivity;
mod surface_basis;
mod targets;
#[cfg(test)]
mod tests;

pub use error::OptimizeError;
pub use merit::TargetMeasure;
pub use search::{GradientMethod, OptimizeOutcome, OptimizeSettings, OptimizeState, optimize};
