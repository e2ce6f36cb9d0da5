//! Which nodes of a mesh are those of its sector, and where the body joins it.

use super::mesh::Mesh;

/// The nodes of a sector.
pub(super) struct SectorNodes {
    /// Those that move each element, also the elements of the body.
    pub moving: Vec<Vec<usize>>,
    /// Of both sides, without those of the body alone.
    pub sides: [Vec<usize>; 2],
    /// Those between the sides at which the body begins.
    pub between: Vec<usize>,
    /// The other free ones of the sector.
    pub inside: Vec<usize>,
}

impl SectorNodes {
    pub fn of(mesh: &Mesh) -> SectorNodes {
        let all = 0..mesh.elements.len();
        let moving: Vec<Vec<usize>> = all.map(|element| mesh.moving(element)).collect();
        let [mut is_inside, in_body] =
            [&moving[..mesh.body], &moving[mesh.body..]].map(|elements| {
                let mut are_in = vec![false; mesh.points.len()];
                let nodes = elements.iter().flatten();
                nodes.for_each(|node| are_in[*node] = !mesh.held[*node]);
                are_in
            });
        let pairs = mesh.sides[0].iter().zip(&mesh.sides[1]);
        let sides: (Vec<usize>, Vec<usize>) = pairs.filter(|(node, _)| is_inside[**node]).unzip();
        let sides = <[Vec<usize>; 2]>::from(sides);
        (sides.iter().flatten()).for_each(|node| is_inside[*node] = false);
        let free = (0..is_inside.len()).filter(|node| is_inside[*node]);
        let (between, inside) = free.partition(|node| in_body[*node]);
        SectorNodes {
            moving,
            sides,
            between,
            inside,
        }
    }

    /// Where the elements of the sector, and the nodes that move them, lie, in their order, m.
    pub fn places(&self, mesh: &Mesh) -> Vec<[f64; 3]> {
        let elements = mesh.elements.iter().zip(&self.moving).take(mesh.body);
        let of_elements = elements.flat_map(|(nodes, moving)| nodes.iter().chain(moving));
        let kept = self.sides[0].iter().chain(&self.between);
        of_elements
            .chain(kept)
            .map(|node| mesh.points[*node])
            .collect()
    }
}
