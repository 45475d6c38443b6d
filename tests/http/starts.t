#!/usr/bin/perl
# The demo's daemon starts every time: 200 times in `make soak`. And a daemon that does not start is told apart.
use strict;
use warnings;
use File::Temp qw(tempdir);
use Test::More;

my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my $times = $ENV{VT_SOAK} ? 200 : 3;
my $said = `tests/demo/starts.sh $binary $times 2>&1`;
is $? >> 8, 0, "$times starts of the demo's daemon";
like $said, qr/^$times starts of the demo's daemon, 0 failures/m, 'none fails' or diag $said;
note $said;

# Binaries that do not do what is asked of them.
my $dir = tempdir(CLEANUP => 1);
sub binary {
    my ($script) = @_;
    open my $out, '>', "$dir/voronoid" or die "$dir/voronoid: $!";
    print $out "#!/bin/sh\n$script\n";
    close $out;
    chmod 0755, "$dir/voronoid";
}
for my $case (
    ['that ends at once', 'echo it is broken >&2; exit 3', qr/it is broken/],
    ['that listens nowhere', q(echo '{"msg":"listening","address":"127.0.0.1:1"}' >&2; exec sleep 60), qr/curl: \(7\)/],
    ['that does not end well', "exec 3>&2; '$binary' \"\$@\" & trap 'kill \$!; wait; exit 4' TERM; wait", qr/1 failures/],
) {
    my ($name, $script, $message) = @$case;
    $script =~ s{'build/}{'$ENV{PWD}/build/} if $binary !~ m{^/};
    binary($script);
    $said = `tests/demo/starts.sh $dir/voronoid 1 2>&1`;
    isnt $? >> 8, 0, "a daemon $name is a failure";
    like $said, $message, 'and it is said why';
}
done_testing;
