//! The textual form.

use proptest::prelude::*;

use super::*;

#[test]
fn mends_are_written_as_they_are_read() {
    let table = [
        ("weld", "weld=0"),
        ("weld=0.25", "weld=0.25"),
        (" weld = 0.1 % ", "weld=0.1%"),
        ("debris", "debris=0.01"),
        ("debris=5%", "debris=0.05"),
        ("debris=100", "debris=100"),
        ("debris=1.0", "debris=1.0"),
        ("largest", "largest"),
        ("orient", "orient"),
        ("close", "close=flat"),
        ("close=smooth", "close=smooth"),
        ("close=flat:12.5", "close=flat:12.5"),
        ("close=smooth:2%", "close=smooth:2%"),
        ("smooth", "smooth=10"),
        ("smooth=200", "smooth=200"),
        ("decimate", "decimate=0.5"),
        ("decimate=20000", "decimate=20000"),
        ("decimate=100%", "decimate=1.0"),
        ("remesh", "remesh=1%"),
        ("remesh=0.5", "remesh=0.5"),
    ];
    for (text, written) in table {
        let mend = Mend::parse(text).unwrap();
        assert_eq!(mend.to_string(), written);
        assert_eq!(Mend::parse(written), Ok(mend), "{written}");
        let json = serde_json::to_string(&mend).unwrap();
        assert_eq!(json, format!("\"{written}\""));
        assert_eq!(serde_json::from_str::<Mend>(&json).unwrap(), mend);
    }
    let list = "weld=0,debris=0.01,orient,close=flat";
    let mends = list_from_text(" weld,debris , orient,close").unwrap();
    assert_eq!(text_from_list(&mends), list);
}

#[test]
fn what_cannot_be_understood_is_told_with_its_place_and_what_would_be_right() {
    let table = [
        ("", 1, "", "missing"),
        ("weld,,orient", 2, "", "missing"),
        ("wedl", 1, "wedl", "`weld` is near"),
        ("weld,Orient", 2, "Orient", "`orient` is near"),
        ("close,bake", 2, "bake", "there are weld, debris, largest"),
        ("weld=-1", 1, "weld=-1", "from 0 on"),
        ("weld=nan", 1, "weld=nan", "a number from 0 on"),
        ("weld=inf", 1, "weld=inf", "a number from 0 on"),
        ("weld=1e16", 1, "weld=1e16", "a number from 0 on"),
        ("weld=101%", 1, "weld=101%", "a number from 0 on"),
        ("debris=0", 1, "debris=0", "a share above 0"),
        ("debris=1.5", 1, "debris=1.5", "a share above 0"),
        ("largest=2", 1, "largest=2", "has no value"),
        ("close=round", 1, "close=round", "`flat` or `smooth`"),
        ("close=flat:0", 1, "close=flat:0", "above 0"),
        ("smooth=0", 1, "smooth=0", "from 1 to 200"),
        ("smooth=201", 1, "smooth=201", "from 1 to 200"),
        ("decimate=0", 1, "decimate=0", "a number of triangles"),
        ("decimate=-5", 1, "decimate=-5", "a number of triangles"),
        ("remesh=0", 1, "remesh=0", "above 0"),
        ("remesh=0%", 1, "remesh=0%", "above 0"),
    ];
    for (text, place, word, told) in table {
        let error = list_from_text(text).unwrap_err();
        assert_eq!((error.place, error.word.as_str()), (place, word), "{text}");
        assert!(error.problem.contains(told), "{text}: {error}");
        assert!(!error.to_string().contains('\n'));
    }
    let long = "orient,".repeat(100) + "orient";
    assert_eq!(list_from_text(&long).unwrap_err().place, 101);
    let word = "é".repeat(5000);
    assert!(Mend::parse(&word).unwrap_err().to_string().len() < 300);
    assert!(serde_json::from_str::<Mend>("\"bake\"").is_err());
}

proptest! {
    #[test]
    fn any_text_is_read_or_told_and_what_is_read_is_written_back(text in "[a-z=,.:%0-9e -]{0,24}") {
        if let Ok(mends) = list_from_text(&text) {
            prop_assert_eq!(list_from_text(&text_from_list(&mends)), Ok(mends));
        }
    }

    #[test]
    fn numbers_keep_all_their_digits(length in 1e-300..1e15_f64, share in 1e-300..=1.0_f64) {
        for mend in [
            Mend::Weld(Weld { distance: Length::Units(length) }),
            Mend::Remesh(Remesh { edge: Length::Percent(100.0 * share) }),
            Mend::Decimate(Decimate { to: Amount::Share(share) }),
        ] {
            prop_assert_eq!(Mend::parse(&mend.to_string()), Ok(mend));
        }
    }
}
