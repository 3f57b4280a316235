!go.
@first +!go <- .add_plan("+!new(X) <- .print(\"new \",X)."); !new(7); .add_plan({ @second +!other : true <- .print("other") }); !other;
   .remove_plan(second); !other.
-!other <- .print("no plan any more").
