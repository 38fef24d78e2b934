//! Whole components kept or dropped, as the report finds them: triangles that hang together by shared vertices, the largest area first.

use super::{Amount, Debris, MendError, Work, clean};
use crate::mesh::Mesh;

pub(super) fn debris(mesh: Mesh, debris: &Debris, work: &mut Work) -> Result<Mesh, MendError> {
    let report = work.report(&mesh)?;
    let largest = report.components.first().map_or(0.0, |first| first.area);
    let stays: Vec<bool> = report
        .components
        .iter()
        .map(|component| match debris.below {
            Amount::Share(share) => component.area >= share * largest,
            Amount::Triangles(least) => component.triangles >= least,
        })
        .collect();
    let dropped: f64 = of(&report.components, &stays, false);
    if dropped > 0.0 {
        let share = 100.0 * dropped / report.area();
        work.remark(
            stays.iter().filter(|stays| !**stays).count(),
            &format!("component dropped ({share:.2} % of the area)"),
            &format!("components dropped ({share:.2} % of the area)"),
        );
    }
    Ok(kept(mesh, &report.component_of_triangle, &stays))
}

pub(super) fn largest(mesh: Mesh, work: &mut Work) -> Result<Mesh, MendError> {
    let report = work.report(&mesh)?;
    let mut stays = vec![false; report.components.len()];
    if let Some(first) = stays.first_mut() {
        *first = true;
    }
    let share = 100.0 * of(&report.components, &stays, true) / report.area();
    work.remark(
        stays.len().saturating_sub(1),
        &format!("component dropped, the largest kept ({share:.2} % of the area)"),
        &format!("components dropped, the largest kept ({share:.2} % of the area)"),
    );
    Ok(kept(mesh, &report.component_of_triangle, &stays))
}

/// The area of those that stay, or of those that do not.
fn of(components: &[crate::mesh::report::Component], stays: &[bool], which: bool) -> f64 {
    let some = components.iter().zip(stays);
    some.filter(|(_, stays)| **stays == which)
        .map(|(component, _)| component.area)
        .sum()
}

fn kept(mut mesh: Mesh, of_triangle: &[u32], stays: &[bool]) -> Mesh {
    let mut components = of_triangle.iter();
    mesh.triangles.retain(|_| {
        let component = components.next();
        component.is_some_and(|number| stays.get(*number as usize).copied().unwrap_or(false))
    });
    clean::without_unused(mesh)
}
