#!/usr/bin/perl
# docker/install.sh while another apt holds the lock, and where it may not install: with an apt-get, dpkg-query and id of our
# own before those of the machine.
use strict;
use warnings;
use File::Temp qw(tempdir);
use Test::More;

my $dir = tempdir(CLEANUP => 1);
system("mkdir $dir/docker && cp docker/install.sh docker/packages.txt $dir/docker") == 0 or die;

sub tool {
    my ($name, $script) = @_;
    open my $out, '>', "$dir/$name" or die "$dir/$name: $!";
    print $out "#!/bin/sh\n$script";
    close $out;
    chmod 0755, "$dir/$name";
}

# Runs install.sh for the stage build: its status and all that it said.
sub install {
    unlink "$dir/calls";
    my $said = `VORONOID_APT_WAIT=20 PATH=$dir:\$PATH $dir/docker/install.sh build 2>&1`;
    return ($? >> 8, $said);
}

sub calls {
    open my $in, '<', "$dir/calls" or return '';
    local $/;
    return scalar <$in>;
}

# An apt-get that finds the lock of $held taken for the first $times calls.
sub apt_get {
    my ($held, $times, $error) = @_;
    tool('apt-get', <<"END");
echo "\$1" >>"$dir/calls"
if [ "\$1" = $held ] && [ "\$(grep -c $held "$dir/calls")" -le $times ]; then
    echo "E: $error" >&2
    exit 100
fi
END
}

tool('dpkg-query', "exit 1\n");
tool('dpkg-deb', "mkdir -p \$3/usr/include/flann && echo found >\$3/usr/include/flann/flann.h\n");
tool('id', "echo 0\n");
tool('sleep', "exit 0\n");

my %error = (
    update  => 'Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)',
    install => 'Unable to acquire the dpkg frontend lock (/var/lib/dpkg/lock-frontend), is another process using it?',
);
for my $held (sort keys %error) {
    apt_get($held, 3, $error{$held});
    my ($status, $said) = install();
    is $status, 0, "$held waits for a lock that is given back";
    is scalar(() = calls() =~ /^$held$/mg), 4, "and tries again until then";
    is scalar(() = $said =~ /Another apt-get is running/g), 1, 'and says so once';
}

apt_get('update', 100000, $error{update});
my ($status, $said) = install();
isnt $status, 0, 'a lock that is never given back fails';
is scalar(() = calls() =~ /^update$/mg), 11, 'after as many tries as two seconds go into the time it waits';
like $said, qr/held by process 7/, 'with the reason of apt-get';

apt_get('install', 100000, 'Unable to locate package nothing');
($status, $said) = install();
isnt $status, 0, 'another failure fails';
is scalar(() = calls() =~ /^install$/mg), 1, 'at once';
like $said, qr/Unable to locate package nothing/, 'with its reason';

unlink "$dir/build/headers/libflann-dev";
apt_get('update', 0, '');
($status, $said) = install();
is $status, 0, 'with all that is missing installed';
is calls(), "update\ninstall\ndownload\n", 'one update, one install, and one package of which only the headers are fetched';
is `cat $dir/build/headers/flann/flann.h`, "found\n", 'which then stand in build/headers';
install();
is calls(), "update\ninstall\n", 'and are not fetched again';

tool('id', "echo 1000\n");
tool('sudo', "exit 1\n");
($status, $said) = install();
is $status, 1, 'without root and sudo nothing is installed';
like $said, qr/^apt-get install -y --no-install-recommends .*\bgcc\b/m, 'and the one line to type is printed';
is calls(), '', 'and apt-get is not called';
done_testing();
