//! What is computed, with a picture of the mesh.

use crate::cases::{Models, shipped};
use crate::mesh_picture;
use crate::page::{Outcome, link};
use gearmesh::compliance::finite_element::{SectorMesh, Settings};
use std::path::Path;

/// The chapter.
pub fn report(_: &Models, plots: &Path) -> Outcome<String> {
    let pair = shipped("palermo2013")?;
    let gear = &pair.geometry.gears[0];
    let settings = Settings::for_pair(&pair);
    let mesh = SectorMesh::new(gear, &settings)?;
    std::fs::write(plots.join("mesh.svg"), mesh_picture::draw(&mesh, gear))?;
    let layers = mesh.stations.len() - 1;
    Ok(format!(
        "One sector of a gear is one tooth with its share of the body down to the held surface (bore; of a ring the \
         outer rim, which may rest on a foundation): a full disc, or rim, web and hub where the pair file has them. Its outline is the generated one: involute, trochoid of the tool's rounded tip, undercut and profile \
         shift included. The section is meshed with 8-node quadrilaterals, graded towards the loaded flank, the fillet and \
         the tip edge, where the elements are a quarter as long, and swept along the helix in layers that are thinner \
         towards both ends of the face and grow with a face of more than 15 modules: 20-node hexahedra. Deeper below the root than a layer pair is thick, layers of full discs and \
         rings merge two by two where the face is at least eight of them wide, but for two at each end; thin layers \
         above move as the side of the thick one does (the mean influence changes by 2e-4 or less). Where a wide contact asks for a \
         wide kernel, elements along the flank grow with it.\n\n{}\
         *Mesh of the paper's gear at level normal, from its nodes: {} elements in the section × {layers} layers. Left the \
         section of one sector (loaded flank bold, held surface below), in the middle its tip edge enlarged, right the flank \
         unrolled, its layers along the face.*\n\n\
         A sector is reduced to its two sides and the nodes of its loaded flank by sparse Cholesky factorisation; a discrete \
         Fourier transform over the equal sectors closes the ring, so that **every tooth of the gear is a real one**: there is \
         no sector size to choose. Loads enter the ring by the few modes in which they act on the sides, and harmonics that others \
         tell to eight digits are interpolated. The result is the normal displacement of the flank nodes of a tooth and its neighbours per \
         unit load. A strip of a contact line is a line load spread across it by a smooth kernel; the kernel's own half-plane \
         logarithm is taken out again, and the Hertz contact, whose width follows the load, put in its place.\n\n\
         **Tip edges.** Beyond the path of contact the tip edge of one gear bears on the flank of the other. The kernel there is \
         no wider than the distance to the edge, down to what the elements resolve. Where that is narrower than the contact, the displacement of a strip under its \
         own load is moved from the bulk to the local contact until the law of the latter suits the widest contact of the pair's \
         loads. That changes nothing as long as the bulk matrix can give it and stay positive definite; loads that change along the \
         line faster than the elements resolve are averaged over their neighbours for it, so that no pair is refused for the \
         length of its strips. And contact has one side only: \
         with the gap alpha s + s²/(2 R) at the distance s from the edge, the pressure between half-planes is \
         sqrt((a - s)/s) (alpha + (s + a/2)/R) / (pi c), alpha the inclination of the flanks, and its displacement replaces that \
         of Hertz. Inside the flank alpha = -(distance to the edge)/R, and the law passes into that of Hertz exactly where \
         contact just reaches the edge. The force acts along the normal of the flank that the edge bears on. Under the tip edge \
         of gear 1 this normal touches the base circle of gear 2, so that its arm about the axis of gear 1 is a few hundredths \
         less than the base radius; the torque given is that on gear 1. What turns the body of the gear whose tip it is and bends its tooth is \
         the component of the force along the circumference, which is that of a force along its own normal times its arm about \
         its own axis over the base radius: by this its displacements in the elastic model, which knows normal forces alone, are \
         taken, for the force and for the displacement. In the program of \
         `scripts/contact_reference.py` the direction alone changes the STE by 0.6 to 1.4 % where an edge takes up load, and this rule by 0.65 to 1.5 %. And the tip is a wedge: near a corner of the angle phi (flank \
         to land) a tooth gives way by the logarithm of a half-plane times pi (phi + sin phi cos phi) / (phi² - sin² phi), 1.4 at 121 degrees. \
         What is more than a half-plane's, r c_g, adds r c_g ln(d/m) to dh/dw of a contact whose middle lies m from the edge, d the \
         distance of the contact line from it, no less than what the elements resolve.\n\n\
         **Modified flanks** touch where they come closest, not on the nominal line: gap = min over s of (removal of both gears + \
         s²/(2 R)), s along the flanks in the transverse section, the lengths of roll moved by s rb/rho. The local contact there \
         takes the gap as it is: 1/R is the curvature of the involutes plus that of what is removed, and where the contact \
         reaches the start of a relief the law is that of half-planes on parabolas joined by a kink or by a jump of curvature. With G(m, a) the \
         mean of the gap over a contact from m - a to m + a under the weight 1/sqrt(a² - (s - m)²), line load and penetration are \
         c w = a dG/da and h = G + c w ln(2 L/a), m such that dG/dm = 0: of all contacts the one that carries most at the \
         penetration h. It passes into Hertz, or into the law of the tip edge, where contact just reaches the \
         start of the relief. Pressure at a sharp kink has no bound; given is that of the half-ellipse of the same \
         line load and spread. A strip takes the gap at its middle. The curvature of a topography is its second difference over 0.02 R to both sides.\n\n\
         **Contact** is the frictionless complementarity problem over all strips of all tooth pairs in reach, solved by Newton's \
         method to a relative residual of 1e-10.\n",
        link("mesh", "Mesh of one sector"),
        mesh.elements.len(),
    ))
}
